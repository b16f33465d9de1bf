"""Collisions of a few wet bodies."""
