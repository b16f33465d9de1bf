"""Worker of a scene in YADE with its own bridges: contacts of `ViscElCapMat` in place of the scene's. Started by moist.py."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from pywet.engines.process import worker_border
from pywet.engines.yade import worker
from pywet.util.files import write_json


def contacts(task: dict[str, Any]) -> tuple[list[int], list[Any], list[Any], float]:
    """Return materials, functors and range of contacts with bridges, as `in_yade.contacts` returns dry ones."""
    from yade import (  # type: ignore[import-not-found]
        Ip2_ViscElCapMat_ViscElCapMat_ViscElCapPhys,
        Law2_ScGeom_ViscElCapPhys_Basic,
        O,
        ViscElCapMat,
    )

    liquid = task["liquid"]
    common = {
        "Capillar": True, "CapillarType": liquid["law"], "Vb": liquid["volume"], "gamma": liquid["surface_tension"],
        "theta": liquid["angle_deg"],
    }  # fmt: skip
    bodies = zip([1000.0, *task["density"]], liquid["materials"], strict=True)
    kinds = [O.materials.append(ViscElCapMat(density=rho, **common, **numbers)) for rho, numbers in bodies]
    functors = [Ip2_ViscElCapMat_ViscElCapMat_ViscElCapPhys()], [Law2_ScGeom_ViscElCapPhys_Basic()]
    return kinds, *functors, task["reach"]


def bridges() -> list[dict[str, Any]]:
    """Return the active bridges of YADE's own law at the end: volume, gap, whether it is to a wall, its rupture distance."""
    from yade import O

    found = []
    for i in O.interactions:
        if i.isReal and i.phys.liqBridgeCreated:
            other = O.bodies[i.id2].shape.__class__.__name__ + O.bodies[i.id1].shape.__class__.__name__
            found.append(
                {
                    "volume": i.phys.Vb,
                    "gap": -i.geom.penetrationDepth,
                    "wall": "Polyhedra" in other,
                    "rupture": i.phys.sCrit,
                }
            )
    return found


def run(run_dir: Path, folder: Path) -> None:
    """Run a task, and write the bridges at its end."""
    worker.run(run_dir, folder, contacts)
    write_json(folder / "bridges.json", bridges())


if __name__ == "__main__":
    sys.exit(worker_border(run))
