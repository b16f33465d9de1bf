"""Liquid in the user's LIGGGHTS script, by one additional line `fix ID all pywet liquid wet.yaml`."""
