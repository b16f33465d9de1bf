"""How wrong does a coarser setting make a run, and what does it save? The physics stays; `effects` leaves parts of it out.

`knobs.py` says what is varied, `bodies.py` and `sieve.py` are the scenes, `measure.py` does one run, `study.py` all of them;
`errors.py` tells errors from chance, `result.py` makes the table, `choice.py` chooses from it, `cost.py` predicts
times; `page.py`, `blocks.py`, `figures.py` show; `scatter.py`: the scatter of inputs beside settings.
`table.json` is the stored result that `pywet plan CASE --accuracy` reads.
"""
