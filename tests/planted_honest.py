"""What both pages of planted faults say of themselves in the end."""

TEXT = """## Honest read

Each fault was planted alone, and the list is of faults that somebody thought of: it shows that these are found and named,
not that others would be. [Faults by chance](faults_by_chance.md) are the fairer test, and find
less. A wrong reading of a paper that both sides share is found by no replay ([shared
readings](shared_readings.md)).
"""
