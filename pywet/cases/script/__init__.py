"""Liquid in a LIGGGHTS script of the user's own: one line `fix ID all pywet liquid wet.yaml` more."""
