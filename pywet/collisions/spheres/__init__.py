"""Collisions of N wet spheres in a plane (Davis 2023); the public interface is `pywet.collisions.spheres.command`."""
