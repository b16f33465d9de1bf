"""Collisions of a few wet bodies: sphere and wall (Buck et al. 2018), spheres in a plane (Davis 2023); no engine is needed."""

ITEMS = ("fig06", "fig07", "fig08", "fig09", "fig10", "fig11", "fig12", "fig13", "accuracy", "engine", "readings")
"""Figures and tables of the page results/wall_collision; here because the workflow lists them before anything is imported."""
