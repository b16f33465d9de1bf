"""Do independent programs give the same numbers? One table compares every quantity of every program with the best known value.

One source (module `forces`, `replayed`, …) writes the cells of its rows to one JSON file, so that a source that fails
affects only its own cells; `page.py` combines them. `sources.py` lists the sources, `rows.py` the rows. Two-body
scenes are run here; for whole scenes the results of `engines` and of the screening cases are read.
"""
