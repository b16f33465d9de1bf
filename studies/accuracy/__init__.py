"""How large is the error of a coarser setting, and how much time does it save? `effects` leaves parts of the physics out.

`bodies.py` and `sieve.py` are the scenes, `measure.py` does one run, `study.py` all of them and makes the table that
`pywet/cost` chooses from; `errors.py` separates errors from statistical uncertainty; `page.py`, `blocks.py`, `figures.py` draw;
`scatter.py`: the scatter of inputs in addition to settings.
"""
