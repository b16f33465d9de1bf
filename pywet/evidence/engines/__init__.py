"""Does the same scene end alike in another engine? Beds, pulls, contacts, dry screening in LIGGGHTS, YADE and stock models.

Here the scenes are run and compared one by one; `agreement` takes their results into its one table.
"""
