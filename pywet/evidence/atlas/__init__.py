"""The law atlas: how far every law is from the exact bridge, where, and what a call costs. `pywet laws --atlas`."""
