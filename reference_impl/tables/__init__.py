"""The tables that a person reads, made a second time from the raw logs, and compared with those of the run."""
