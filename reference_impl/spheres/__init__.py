"""Collisions of N wet spheres, a second time."""
