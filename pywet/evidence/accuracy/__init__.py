"""What accuracy costs: every setting of a run against a finer one, its error in what a user wants and its price.

`knobs.py` says what is varied, `bodies.py` and `sieve.py` are the scenes, `runs.py` the list of runs and how one is done and
kept, `errors.py` turns them into errors with their spread, `front.py` and `choice.py` choose, `cost.py` predicts times,
`figures.py`, `blocks.py` and `page.py` show. `table.json` is the stored result that `pywet plan CASE --accuracy` reads.
"""
