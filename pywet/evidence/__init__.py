"""What the paper says of its simulations, put to the test on full-scale runs: campaign, kept tables, statements, page."""
