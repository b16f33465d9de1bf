"""Where does a run break down: values not finite, liquid lost, energy created? `accuracy` measures the error of stable runs.

`maps.py`, `hard_scenes.py` and `random_cases.py` contain the scenes, many `cells.py` in one engine run; `judge.py`
judges a cell, `running.py` runs them and reports all outcomes, `study.py` executes all runs; `page.py` makes the
page.
"""
