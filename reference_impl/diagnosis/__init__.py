"""Diagnosis: name the fault behind a replay that disagrees."""
