"""Collisions of a wet sphere with a wall (or another sphere) by the force balance of Buck et al. (2018); no engine is needed."""
