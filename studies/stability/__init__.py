"""Where does a run break down: not finite, liquid lost, energy made? `accuracy` asks how wrong a run is that holds.

`maps.py`, `hard_scenes.py` and `random_cases.py` are the scenes, many `cells.py` in one engine run; `judge.py` judges a cell,
`running.py` runs them and says what became of all, `study.py` does all runs; `page.py` shows.
"""
