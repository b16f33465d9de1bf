"""Table of agreement: every quantity by every program that can express it, against the best truth there is for it.

One source (module `forces`, `replayed`, …) gives the cells of its rows as one JSON file, so that a source that fails blanks
its own cells only; `page.py` puts them together. `sources.py` lists the sources, `rows.py` the rows.
"""
