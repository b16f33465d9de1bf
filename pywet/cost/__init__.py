"""Time, memory and disk space of a run, and settings for a required accuracy.

`knobs.py` names the settings, `choice.py` chooses from the stored table of the accuracy study (`table.json`), `cost.py` predicts
times from `counts.py` and from what `trial.py` measured on this machine, `needs.py` adds memory and disk.
"""
