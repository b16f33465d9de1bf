"""N wet spheres in a plane (Davis 2023): dynamics, integrators, events, outcomes; the public face is
`pywet.collisions.spheres.command`."""
