"""A script as users have them: spheres are inserted into a box with planes for walls, and fall."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

LINE = "fix wet all pywet liquid wet.yaml every 100"
WET = "liquid: {percent: 1.0}\ncontact_angle_deg: 15\nwalls: dry\n"
PLANES = "\n".join(
    f"fix {axis}{k} all wall/gran model hertz tangential history primitive type 1 {axis}plane {at}"
    for axis, k, at in (("x", 1, -0.02), ("x", 2, 0.02), ("y", 1, -0.02), ("y", 2, 0.02), ("z", 1, 0.0))
)
BEFORE = f"""# packing in a box
atom_style      granular
atom_modify     map array
boundary        f f f
newton          off
communicate     single vel yes
units           si
region          reg block -0.02 0.02 -0.02 0.02 0 0.08 units box
create_box      1 reg
neighbor        0.002 bin
neigh_modify    delay 0
fix             m1 all property/global youngsModulus peratomtype 5.e6
fix             m2 all property/global poissonsRatio peratomtype 0.45
fix             m3 all property/global coefficientRestitution peratomtypepair 1 0.6
fix             m4 all property/global coefficientFriction peratomtypepair 1 0.4
pair_style      gran model hertz &
                tangential history
pair_coeff      * *
timestep        0.00001
fix             gravi all gravity 9.81 vector 0.0 0.0 -1.0
{PLANES}
fix             pts1 all particletemplate/sphere 15485863 atom_type 1 density constant 2500 radius constant 0.002
fix             pts2 all particletemplate/sphere 15485867 atom_type 1 density constant 2500 radius constant 0.003
fix             pdd1 all particledistribution/discrete 32452843 2 pts1 0.5 pts2 0.5
region          fill block -0.018 0.018 -0.018 0.018 0.002 0.07 units box
fix             ins all insert/pack seed 49979687 distributiontemplate pdd1 vel constant 0. 0. -0.3 &
                insert_every once overlapcheck yes all_in yes particles_in_region 200 region fill
fix             integr all nve/sphere
thermo          1000
run             1
unfix           ins
"""
SHAKEN = BEFORE.replace(
    "fix             pts1",
    """fix             plate all mesh/surface/stress file plate.stl type 1
fix             meshwall all wall/gran model hertz tangential history mesh n_meshes 1 meshes plate
fix             shake all move/mesh mesh plate wiggle amplitude 0. 0. 0.0005 period 0.02
fix             pts1""",
)
"""The same with a plate below the spheres that vibrates."""
PLATE_ALONE = "{plate: 30, x1: dry, x2: dry, y1: dry, y2: dry, z1: dry}"
"""Its walls, of which the plate is wet."""
CORNERS = ("-.019 -.019", ".019 -.019", ".019 .019", "-.019 .019")
PLATE = "solid plate\n{}endsolid plate\n".format(
    "".join(
        "facet normal 0 0 1\nouter loop\n"
        + "".join(f"vertex {CORNERS[k]} .001\n" for k in corners)
        + "endloop\nendfacet\n"
        for corners in ((0, 1, 2), (0, 2, 3))
    )
)
AFTER = """dump            d all custom 500 dump.txt id x y z vx vy vz omegax omegay omegaz
dump_modify     d sort id format "%d %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g"
variable        n loop 2
label           again
run             1500
next            n
jump            SELF again
"""


def write(folder: Path, *, before: str = BEFORE, line: str = LINE, after: str = AFTER, wet: str = WET) -> Path:
    """Script and liquid in a folder."""
    (folder / "wet.yaml").write_text(wet)
    (folder / "plate.stl").write_text(PLATE)
    script = folder / "in.script"
    script.write_text(f"{before}{line}\n{after}")
    return script


def run(folder: Path, *program: str) -> subprocess.CompletedProcess[str]:
    """Run the script of a folder there, by the command `pywet liggghts` if not said otherwise."""
    words = program or (sys.executable, "-m", "pywet.cli.app", "liggghts")
    environment = {**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    return subprocess.run(
        [*words, "-in", "in.script"],
        cwd=folder,
        capture_output=True,
        text=True,
        errors="replace",
        check=False,
        env=environment,  # the engine's last line may end in bytes that are no text
    )


def read(text: str) -> str:
    """Output without the line breaks of a narrow terminal."""
    return " ".join(text.split())
