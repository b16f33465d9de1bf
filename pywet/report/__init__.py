"""Pages, pictures, VTK files and 3-D scenes of runs."""
