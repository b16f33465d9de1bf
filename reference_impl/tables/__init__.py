"""The tables that a person reads, made a second time from the raw logs, and held against those of the run."""
