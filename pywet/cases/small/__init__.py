"""The work bench: bodies and ready scenes for every study, comparison and test."""
