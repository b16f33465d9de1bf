"""The scene of a run against the configuration it was built from: read, computed and measured with the reference's own code."""
