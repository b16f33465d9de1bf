"""Studies on pywet: a package for each question, in a checkout only. `pywet study` runs them from there.

- `accuracy`: how large is the error of a coarser setting, and how much time does it save?
- `stability`: where does a run break down?
- `effects`: which effects may be left out?
- `cross_code`: do independent programs give the same numbers?
- `engines`: does the same scene have the same results in another engine?
- `law_comparison`: how far is each law from the exact bridge?
- `stock`: which forces do the programs' own bridge models give?
- `full_scale`: does the simulation confirm the paper's statements?
- `search`: under which readings and dimensions are statements confirmed?
- `buck2018`, `davis2023`: figures and numbers of two papers on wet collisions.

`study.py` is the frame of the first three, `command.py` holds the commands, `references.py` the reference scenes of digests. The
program, `pywet`, imports nothing of it.
"""
