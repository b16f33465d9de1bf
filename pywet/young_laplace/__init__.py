"""The exact liquid bridge: axisymmetric Young-Laplace without gravity, and its table for engines."""

from pywet.young_laplace.bridge import Bodies, Bridge, Rupture, rupture, solve

__all__ = ["Bodies", "Bridge", "Rupture", "rupture", "solve"]
