"""Collisions of a wet sphere with a wall (or another sphere) by the force balance of Buck et al. (2018); no engine is needed."""

ITEMS = ("fig06", "fig07", "fig08", "fig09", "fig10", "fig11", "fig12", "fig13", "accuracy", "engine", "readings")
"""Figures and tables of the page results/wall_collision; here because the workflow lists them before anything is imported."""
