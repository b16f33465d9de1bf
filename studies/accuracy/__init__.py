"""How large is the error of a coarser setting, and how much time does it save? In contrast, `effects` omits parts of the physics.

`bodies.py` and `sieve.py` contain the scenes, `measure.py` executes one run, `study.py` all of them and makes the
table that `pywet/cost` chooses from; `errors.py` separates errors from statistical uncertainty; `page.py`,
`blocks.py`, `figures.py` make the page; `scatter.py` compares the scatter of inputs with the settings.
"""
