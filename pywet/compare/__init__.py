"""Significant differences between two finished runs or two groups of seeds: `pywet compare` and `pywet digest`.

`quantities.py` says what is compared, `statistics.py` how, `verdict.py` puts it in words; a digest is a stored run to hold others
against. The other rooms judge scenes of their own and take the statistics from here.
"""
