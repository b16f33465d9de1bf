"""A wet sphere against a wall (Buck et al. 2018): force balance, sweeps, figures; two modules alone know the engine."""
