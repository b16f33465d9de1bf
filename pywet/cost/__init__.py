"""How much time, memory and disk a run takes, and which settings an accuracy allows.

`knobs.py` names the settings, `choice.py` chooses from the stored table of the accuracy study (`table.json`), `cost.py` predicts
times from `counts.py` and from what `trial.py` measured on this machine, `needs.py` adds memory and disk.
"""
