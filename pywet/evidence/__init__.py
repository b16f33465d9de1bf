"""What is known of pywet: a room for each question. `study.py` is the frame of the first three, `command.py` their commands.

- `accuracy`: how wrong does a coarser setting make a run, and what does it save?
- `stability`: where does a run break down?
- `effects`: which effects may be left out?
- `agreement`: do independent programs give the same numbers?
- `engines`: does the same scene end alike in another engine?
- `atlas`: how far is each law from the exact bridge?
- `compare`: do two runs, or two groups of seeds, differ beyond chance?
- `full_scale`: does the simulation say what the paper says?
"""
