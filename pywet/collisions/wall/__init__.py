"""A wet sphere against a wall (Buck et al. 2018): force balance, sweeps, figures; `engine.py` and `twin.py` alone know the engine."""
