"""Construct scenes: screening cases, user-defined scenes, small scenes of a few bodies or a bed."""
