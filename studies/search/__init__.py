"""Search for readings and dimensions of the rig under which the statements of a paper are confirmed."""
