"""Recompute the result tables from the raw logs, and compare them with those of the run."""
