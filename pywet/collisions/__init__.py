"""Collisions of a few wet bodies: sphere and wall (Buck et al. 2018), spheres in a plane (Davis 2023); no engine is needed."""
