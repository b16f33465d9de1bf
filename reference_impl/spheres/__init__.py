"""Independent solution of collisions of N wet spheres."""
