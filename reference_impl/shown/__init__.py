"""Outputs of a run for users, read from their files and compared with the logs."""
