"""Does the simulation say what the paper says? The cases at the paper's own size: campaign, kept tables, statements, page."""
