"""Does the same scene have the same results in another engine? Beds, contacts, dry screening in LIGGGHTS, YADE and stock models.

The scenes are run here; `cross_code` adds their results to its table, `compare` judges groups of seeds.
"""
