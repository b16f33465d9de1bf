"""Collision of a wet sphere with a wall (Buck et al. 2018): force balance, sweeps, figures."""
