"""Does the same scene end alike in another engine? Beds, contacts, dry screening in LIGGGHTS, YADE and stock models.

Here the scenes are run; `agreement` takes their results into its one table, `compare` judges groups of seeds.
"""
