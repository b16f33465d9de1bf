"""Compare the scene of a run with its configuration, which is read, computed and measured with the reference's own code."""
