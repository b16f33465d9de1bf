"""Significant differences between two finished runs or two groups of seeds: `pywet compare` and `pywet digest`.

`quantities.py` defines what is compared, `statistics.py` how, `verdict.py` states the result; a digest is a stored
run with which others are compared. Other packages use these statistics for their own scenes.
"""
