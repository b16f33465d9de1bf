"""The exact liquid bridge: axisymmetric Young-Laplace without gravity, and its table for engines."""

from pywet.laws.exact_bridge.bridge import Bodies, Bridge, Rupture, rupture, solve, solve_many

__all__ = ["Bodies", "Bridge", "Rupture", "rupture", "solve", "solve_many"]
