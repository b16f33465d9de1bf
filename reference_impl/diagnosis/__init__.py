"""Names the fault behind a replay that disagrees."""
