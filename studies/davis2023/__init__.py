"""Figures and numbers of Davis (2023), wet collisions of spheres."""
