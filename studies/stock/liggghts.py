"""Force of LIGGGHTS' own cohesion models at given gaps, from the installed program, with bodies moved at constant speed.

The models compute the volume of a bridge from the liquid content of the spheres (volume of liquid / volume of sphere). The
content is chosen so that this volume is the one asked for:
  washino: V = 0.05 (L_i + L_j);   at a wall V = 0.05 L_i
  easo:    V = sum of (L_i/2)(1 - sqrt(1 - r_j²/(r_i+r_j)²));   at a wall V = L_i/2
with L_i = (4/3) pi r_i³ content. Both spheres get the same content. The viscosity is zero, so speed does not matter; the
contact is too soft to be felt, so at an overlap too the force is that of the liquid alone.
"""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path

import jinja2
import numpy as np
import pandas as pd

from pywet.errors import PywetError
from pywet.shipped import place
from studies.stock.points import Floats, checked, expressible, run_program, smaller_radius, with_force

LIGGGHTS_MODELS = {"washino": "washino/capillary/viscous", "easo": "easo/capillary/viscous"}
DECK = "stock_pairs.liggghts.j2"
STEPS = 100
TIME_STEP = 1e-6
STIFFNESS = 1e-12
OVERLAP = 1e-6
"""Initial overlap over the smaller radius: `easo` makes a bridge only at touch."""
BATCH = 400


def liggghts_force(points: pd.DataFrame, model: str = "washino") -> pd.DataFrame:
    """Return the attraction [N] by the stock model at each point (columns: see points.COLUMNS); adds `force` and `reason`.

    A point with S = 0 is measured at a gap of 1e-7 of the smaller radius, S < 0 at that overlap. Beyond the model's own
    rupture distance the force is zero. PywetError if the program is missing or stops.
    """
    if model not in LIGGGHTS_MODELS:
        raise PywetError(f"the model {model} was asked for; expected one of {', '.join(LIGGGHTS_MODELS)}")
    table = checked(points)
    table["content"], table["row"] = liquid_content(table, model), np.arange(len(table))
    refused = expressible(table)
    table = table[~np.isin(np.arange(len(table)), list(refused))]
    force = np.full(len(points), np.nan)
    for _, group in table.groupby(["surface_tension", "contact_angle", "contact_angle_j"]):
        for start in range(0, len(group), BATCH):
            batch = group.iloc[start : start + BATCH]
            force[batch["row"].to_numpy()] = _measure(batch, LIGGGHTS_MODELS[model])
    return with_force(points, force, "LIGGGHTS", refused)


def liggghts_drag(points: pd.DataFrame, model: str, viscosity: float) -> pd.DataFrame:
    """Normal viscous drag over the speed [N s/m] of a stock model: force with the viscosity less that without, over the speed.

    Points as for `liggghts_force`, apart (S > 0) and of one surface tension and pair of angles; adds the column `drag`.
    """
    table = checked(points)
    table["content"] = liquid_content(table, model)
    speed = (table["gap"].to_numpy(float) + OVERLAP * smaller_radius(table)) / (STEPS * TIME_STEP)
    wet, dry = (_measure(table, LIGGGHTS_MODELS[model], eta) for eta in (viscosity, 0.0))
    return points.assign(drag=(wet - dry) / speed)


def liquid_content(table: pd.DataFrame, model: str) -> Floats:
    """Return the liquid per volume of sphere at which the model's bridge has the volume of each point."""
    ri, rj = table["radius_i"].to_numpy(float), table["radius_j"].to_numpy(float)
    wall = np.isinf(rj)
    finite_j = np.where(wall, ri, rj)
    sphere_i, sphere_j = 4 / 3 * np.pi * ri**3, np.where(wall, 0.0, 4 / 3 * np.pi * finite_j**3)
    if model == "washino":
        drawn = 0.05 * (sphere_i + sphere_j)
    else:
        apart = np.where(wall, ri, ri + finite_j)
        drawn = 0.5 * sphere_i * (1 - np.sqrt(1 - (finite_j / apart) ** 2))
        drawn += 0.5 * sphere_j * (1 - np.sqrt(1 - (ri / apart) ** 2))
    return np.asarray(table["volume"].to_numpy(float) / drawn, dtype=float)


@dataclass(frozen=True)
class Layout:
    """Positions of the bodies of a run: lines of the data file, settings, x of each point, half width of the box."""

    rows: list[str]
    atoms: list[dict[str, object]]
    x: Floats
    half_width: float
    farthest: float
    """Largest distance of a bridge over the sum of radii, for the engine's neighbour list."""


def _layout(batch: pd.DataFrame) -> Layout:
    """Return a position on the x axis for each point, so far apart that points do not interact."""
    ri, rj, gap = (batch[name].to_numpy(float) for name in ("radius_i", "radius_j", "gap"))
    wall = np.isinf(rj)
    rupture = (1 + np.pi / 4) * np.cbrt(batch["volume"].to_numpy(float))  # both models': (1 + theta/2) V^(1/3)
    farthest = 1 + 1.5 * float(np.max(rupture / (ri + np.where(wall, 0.0, rj))))
    largest = float(np.max(np.where(wall, ri, np.maximum(ri, rj))))
    pitch = 6 * farthest * largest + 2 * float(np.max(gap))
    x = pitch * np.arange(1.0, len(batch) + 1.0)
    start = -OVERLAP * smaller_radius(batch)
    speed = (gap - start) / (STEPS * TIME_STEP)
    rows: list[str] = []
    atoms: list[dict[str, object]] = []
    for k, content in enumerate(batch["content"]):
        # a sphere above a wall at z = 0, or j above i at z = 0: the upper body moves
        upper, lower = (ri[k], 0.0) if wall[k] else (rj[k], ri[k])
        places = [] if wall[k] else [(1, ri[k], 0.0, 0.0)]
        places.append((1 if wall[k] else 2, upper, lower + upper + start[k], speed[k]))
        for kind, radius, z, v in places:
            rows.append(f"{len(rows) + 1} {kind} {2 * radius:.17g} 2500 {x[k]:.17g} 0 {z:.17g}")
            atoms.append({"id": len(rows), "content": f"{content:.17g}", "speed": f"{v:.17g}"})
    return Layout(rows, atoms, x, 4 * largest + pitch, farthest)


def _measure(batch: pd.DataFrame, model: str, viscosity: float = 0.0) -> Floats:
    """Run the program once with a separate position for each point."""
    layout = _layout(batch)
    wall = np.isinf(batch["radius_j"].to_numpy(float))
    first = batch.iloc[0]
    values = {
        "model": model,
        "skin": f"{0.1 * np.min(smaller_radius(batch)):.17g}",
        "stiffness": STIFFNESS,
        "viscosity": f"{viscosity:.17g}",
        "surface_tension": f"{first['surface_tension']:.17g}",
        # the engine expects degrees
        "contact_angle_i": f"{np.degrees(first['contact_angle']):.17g}",
        "contact_angle_j": f"{np.degrees(first['contact_angle_j']):.17g}",
        "farthest": f"{layout.farthest:.17g}",
        "time_step": TIME_STEP,
        "steps": STEPS,
        "walls": bool(wall.any()),
        "atoms": layout.atoms,
    }
    text = (place("liggghts_inputs") / DECK).read_text()
    template = jinja2.Template(text, trim_blocks=True, lstrip_blocks=True)
    with tempfile.TemporaryDirectory(prefix="pywet-stock-") as name:
        folder = Path(name)
        (folder / "pairs.data").write_text(_data_file(layout))
        if wall.any():
            _write_walls(folder / "walls.stl", layout.x[wall], 0.5 * layout.half_width)
        (folder / "in.pairs").write_text(template.render(values))
        run_program(["liggghts", "-in", "in.pairs", "-log", "run.log", "-screen", "screen.log"], folder, "liggghts")
        lines = (folder / "forces.txt").read_text().splitlines()
    forces = np.array([line.split() for line in lines[lines.index("ITEM: ATOMS id z fz ") + 1 :]], dtype=float)
    last = np.cumsum(np.where(wall, 1, 2)) - 1  # force on the moved body at each point, directed downward
    return np.asarray(0.0 - forces[last, 2], dtype=float)


def _data_file(layout: Layout) -> str:
    wide = f"{-layout.half_width:.17g} {layout.half_width:.17g}"
    box = f"0 {layout.x[-1] + layout.half_width:.17g} xlo xhi\n{wide} ylo yhi\n{wide} zlo zhi\n"
    head = f"pairs of bodies\n\n{len(layout.rows)} atoms\n2 atom types\n\n{box}\nAtoms\n\n"
    return head + "\n".join(layout.rows) + "\n"


def _write_walls(path: Path, x: Floats, size: float) -> None:
    """Write one triangle in z = 0 under each sphere, so that no sphere interacts with two of them."""
    import meshio

    around = np.array([[-size, -size, 0.0], [size, -size, 0.0], [0.0, size, 0.0]])
    corners = around + np.column_stack([x, np.zeros((len(x), 2))])[:, None]
    triangles = np.arange(3 * len(x)).reshape(-1, 3)
    meshio.write(path, meshio.Mesh(corners.reshape(-1, 3), [("triangle", triangles)]), binary=True)
