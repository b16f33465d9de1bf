"""Small test scenes: bodies and ready-made scenes for studies, comparisons and tests."""
