"""A continuous deck predicted from batch runs, for docs/screens.md."""
