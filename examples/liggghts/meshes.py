"""Makes the STL files of the example scripts: `python meshes.py` writes the folder `meshes` next to it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pywet.geometry import make_surface, write_stl
from pywet.geometry.solids import Part, bin_solid, plate, polygon, tube, wire

FOLDER = Path(__file__).parent / "meshes"


def along_y(parts: list[Part]) -> list[Part]:
    """Solids that were drawn along z."""
    return [(corners[..., [1, 2, 0]], width) for corners, width in parts]


def block(x: tuple[float, float], y: tuple[float, float], z: tuple[float, float]) -> list[Part]:
    return plate(np.array([[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]]), *z)


def sloped(parts: list[Part], degrees: float) -> list[Part]:
    """Turned about y."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return [(corners @ np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]]), width) for corners, width in parts]


def bars(count: int, pitch: float, radius: float, half: float) -> list[Part]:
    """Round bars along x."""
    y = pitch * (np.arange(count) - 0.5 * (count - 1))
    return [(wire(np.array([-half, v, 0.0]), np.array([half, v, 0.0]), radius, 8, 1.1), radius) for v in y]


def flat(name: str, half: float, z: float) -> str:
    """A level square of two triangles, through which spheres come or go."""
    a, b, c, d = (f"vertex {x} {y} {z}" for x, y in ((-half, -half), (half, -half), (half, half), (-half, half)))
    facets = [
        f"facet normal 0 0 1\nouter loop\n{chr(10).join(corners)}\nendloop\nendfacet\n"
        for corners in ((a, b, c), (a, c, d))
    ]
    return f"solid {name}\n{''.join(facets)}endsolid {name}\n"


MESHES = {
    "chute": sloped(block((-0.06, 0.06), (-0.02, 0.02), (-0.003, 0.0)), 30.0),
    "drum": along_y([
        *tube(0.03, 0.003, 24, -0.015, 0.015),
        *plate(polygon(0.033, 24), -0.02, -0.016),
        *plate(polygon(0.033, 24), 0.016, 0.02),
    ]),
    "vessel": bin_solid(0.025, 0.002, 24, 0.0, 0.06),
    "paddle": block((-0.02, 0.02), (-0.002, 0.002), (0.004, 0.025)),
    "screen": bars(7, 0.0075, 0.0015, 0.025),
}  # fmt: skip


def main() -> None:
    """Write all of them."""
    FOLDER.mkdir(exist_ok=True)
    for name, parts in MESHES.items():
        write_stl(make_surface(name, "wall", parts), FOLDER / f"{name}.stl")
    for name, half, z in (("inlet", 0.012, 0.06), ("outlet", 0.03, -0.02)):
        (FOLDER / f"{name}.stl").write_text(flat(name, half, z))


if __name__ == "__main__":
    main()
