"""Sweeps: runs over axes, designs and seeds, declared in one file: `pywet sweep FILE`, `snakemake sweep`; see docs/sweep.md.

`description.py` defines the file, `points.py` the points, `bases.py` the run at a point, `store.py` stores the runs
of all sweeps. `significance.py` has the statistics of the table, with the tests of `pywet compare`.
"""
