"""How wrong does a coarser setting make a run, and what does it save? The physics stays; `effects` leaves parts of it out.

`knobs.py` says what is varied, `bodies.py` and `sieve.py` are the scenes, `measure.py` does one run, `study.py` all of them
and makes the table; `errors.py` tells errors from chance, `choice.py` chooses from the table, `cost.py` predicts times;
`page.py`, `blocks.py`, `figures.py` show; `scatter.py`: the scatter of inputs beside settings.
`table.json` is the stored result that `pywet plan CASE --accuracy` reads.
"""
