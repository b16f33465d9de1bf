"""User-defined scenes, with the same description in Python and YAML: checked, built, run and read."""
