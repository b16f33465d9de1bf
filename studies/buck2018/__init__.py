"""Figures, tables and numbers of Buck et al. (2018), wet collisions of a sphere and a wall."""
