"""Where does a run break down: not finite, liquid lost, energy made? `accuracy` asks how wrong a run is that holds.

`maps.py`, `hard_scenes.py` and `random_cases.py` are the scenes, many `cells.py` in one engine run (`running.py`); `judge.py`
judges a cell, `outcome.py` a run, `study.py` does all of them; `page.py` and `figures.py` show.
"""
