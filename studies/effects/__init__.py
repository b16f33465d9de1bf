"""Which effects may be left out? The choice of `pywet.plan` is compared with all effects on and with each effect off.

`setup.py` and `scenes.py` contain the scenes, `variants.py` executes one run, `study.py` all of them; `measures.py`
computes the quantities of interest, `verdict.py` judges; `page.py` makes the page. Settings are constant here;
`accuracy` varies them.
"""
