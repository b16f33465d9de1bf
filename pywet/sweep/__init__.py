"""Sweeps: runs over axes, designs and seeds, declared in one file: `pywet sweep FILE`, `snakemake sweep`; see docs/sweep.md.

`description.py` is the file, `points.py` the points it asks for, `bases.py` what is run at a point, `store.py` the runs of all
sweeps. Statistics of the table are in `significance.py`, with the tests of `pywet compare`.
"""
