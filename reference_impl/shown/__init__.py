"""What a person gets to see of a run, read back as it stands in its files and compared with the logs."""
