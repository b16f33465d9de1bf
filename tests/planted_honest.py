"""What both pages of planted faults say of themselves in the end."""

TEXT = """## Honest read

Each fault was planted alone, and the list is of faults that somebody thought of: it shows that these are found and named,
not that others would be. [Faults by chance](replay_classes.md#faults-by-chance) are the fairer test, whose score has not
been taken yet. A wrong reading of a paper that both sides share is found by no replay ([shared
readings](shared_readings.md)).
"""
