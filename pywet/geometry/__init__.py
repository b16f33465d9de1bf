"""Walls of the batch screening apparatus as closed triangulated surfaces, and the initial arrangement of the spheres."""

from pywet.geometry.apparatus import Apparatus, ApparatusSpec, build_apparatus
from pywet.geometry.packing import FeedRegion, fill
from pywet.geometry.stl import read_stl, write_stl
from pywet.geometry.surface import Surface, check_surface, make_surface

__all__ = [
    "Apparatus",
    "ApparatusSpec",
    "FeedRegion",
    "Surface",
    "build_apparatus",
    "check_surface",
    "fill",
    "make_surface",
    "read_stl",
    "write_stl",
]
