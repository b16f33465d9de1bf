"""Faults by chance: `python -m tests.faults --new 20 --seed 1` changes the program at random places and says who notices."""
