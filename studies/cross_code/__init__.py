"""Do independent programs give the same numbers? One table: every quantity by every program, against the best truth there is.

One source (module `forces`, `replayed`, …) gives the cells of its rows as one JSON file, so that a source that fails blanks
its own cells only; `page.py` puts them together. `sources.py` lists the sources, `rows.py` the rows. Two bodies are run
here; of whole scenes is read what `engines` and the screening cases have left.
"""
