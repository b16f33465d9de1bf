"""Which effects may be left out? The choice of `pywet.plan` is put to the test: against everything on and each effect off.

`setup.py` and `scenes.py` are the scenes, `variants.py` does one run, `study.py` all of them; `measures.py` says what is
wanted of a scene, `verdict.py` judges; `page.py` shows. The settings stay as they are; `accuracy` varies those.
"""
