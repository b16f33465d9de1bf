"""A scene of one's own, described once and the same in Python and YAML: checked, built, run, read back."""
