"""Columns of the table: programs. Rows: quantity, scene, scale, reasons for empty columns."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

EXACT, REFERENCE, LIGGGHTS, YADE, WASHINO, EASO = "exact", "reference", "liggghts", "yade", "washino", "easo"
LAMMPS = "lammps"
COLUMNS = {
    EXACT: "exact solution",
    REFERENCE: "independent reference",
    LIGGGHTS: "LIGGGHTS + pywet",
    LAMMPS: "LAMMPS + pywet",
    YADE: "YADE",
    WASHINO: "stock washino",
    EASO: "stock easo",
}
"""Column -> name of the program on the page."""


@dataclass(frozen=True)
class Row:
    """One line of the table; deviations are relative to its `scale`."""

    key: str
    group: str
    quantity: str
    scene: str
    scale: str


PAIRS = {"equal": "two equal spheres", "unequal": "spheres 1 : 2", "wall": "sphere and wall"}
REPLAYED = {
    "pair": "spheres 1 : 2 drawn apart, spinning",
    "wall_pull": "sphere drawn from a wall, spinning",
    "bed": "moist bed of 40 spheres",
    "screening": "moist screening, preset paper",
    "screening_exact": "moist screening, preset exact",
}
"""Replayed scene -> name on the page."""
QUANTITIES: dict[str, tuple[str, str, str, tuple[str, ...]]] = {
    "viscous_normal": ("Viscous forces", "viscous normal force", "force at the full relative speed",
                       ("viscous_law", "viscous_normal", "factor_normal")),
    "viscous_tangential": ("Viscous forces", "viscous tangential force", "force at the full relative speed",
                           ("viscous_tangential", "factor_tangential")),
    "torque": ("Viscous forces", "torque", "force at the full relative speed × lever arm", ("torque_i", "torque_j")),
    "force": ("Capillary force", "capillary force and sum of all forces of a bridge", "sum of the terms' sizes",
              ("capillary", "force")),
    "rupture_static": ("Rupture", "static rupture distance", "itself", ("rupture_distance",)),
    "rupture_dynamic": ("Rupture", "rupture limit with the dynamic factor", "itself", ("rupture_limit",)),
    "rupture_due": ("Rupture", "decision: which bridges break in which step", "itself (0: all equal)",
                    ("rupture_due", "standing_beyond_limit", "final_bridges_missing")),
    "volume": ("Liquid", "bridge volume at formation", "itself", ("volume", "contact_volume")),
    "split": ("Liquid", "liquid given back at rupture, split included", "volume of the bridge",
              ("share_i", "share_j", "transfer_table")),
    "films": ("Liquid", "films before and after every event", "mean film of a sphere",
              ("film_i_before", "film_i_after", "film_j_before", "film_j_after", "final_film_spheres", "final_film_walls")),
    "ledger": ("Liquid", "ledger: films + bridges + walls + what left", "liquid put in", ("ledger",)),
}  # fmt: skip
"""Quantity -> group, name, scale, names in replay.json."""


def _rows() -> Iterator[Row]:
    """Yield all rows except `OTHERS`."""
    for preset, law, limit in (
        ("paper", "Rabinovich's law", "Willett's law"),
        ("exact", "exact bridge", "exact limit"),
    ):
        for key, name in PAIRS.items():
            quantity = f"capillary force over gap, {law}"
            yield Row(f"capillary_{preset}_{key}", "Capillary force", quantity, name, "force at that gap")
            yield Row(f"rupture_{preset}_{key}", "Rupture", f"rupture distance, {limit}", name, "itself")
        name, quantity = "equal spheres, overlap to 5 % of r", f"capillary force in overlap, {law}"
        yield Row(f"capillary_{preset}_overlap", "Capillary force", quantity, name, "force at touch")
    for key, (group, quantity, scale, _) in QUANTITIES.items():
        for scene, name in REPLAYED.items():
            yield Row(f"{key}_{scene}", group, quantity, name, scale)


OTHERS = (
    Row("drag_equal", "Viscous forces", "viscous normal drag over gap, Pitois' law", "two equal spheres",
        "drag at that gap"),
    Row("formation_equal", "Liquid", "bridge volume drawn from the same films, Shi & McCarthy", "two equal spheres",
        "itself"),
    Row("split_exact_unequal", "Liquid", "exact split at rupture, engine's table", "spheres 1 : 2",
        "volume of the bridge"),
    Row("momentum_wet", "Conserved", "linear momentum", "three wet spheres, free", "sum of |m v| at the start"),
    Row("momentum_dry", "Conserved", "linear momentum", "oblique dry impact", "sum of |m v| at the start"),
    Row("spin_wet", "Conserved", "angular momentum", "three wet spheres, free",
        "sum of |r × m v| + |I ω| at the start"),
    Row("spin_plain", "Conserved", "angular momentum", "the same without tangential drag",
        "sum of |r × m v| + |I ω| at the start"),
    Row("energy_wet", "Conserved", "energy: change of kinetic energy = works of all effects", "three wet spheres, free",
        "sum of |works|"),
    Row("energy_bed", "Conserved", "energy: change of kinetic energy = works of all effects", "moist bed of 40 spheres",
        "sum of |works|"),
    Row("restitution", "Dry contact", "coefficient of restitution", "head-on dry impact", "itself"),
    Row("oblique_stick", "Dry contact", "tangential velocity and spin after impact, sticking", "oblique dry impact, 10°",
        "impact velocity"),
    Row("oblique_slide", "Dry contact", "tangential velocity and spin after impact, sliding", "oblique dry impact, 60°",
        "impact velocity"),
    Row("case_restitution", "Dry contact", "restitution at the case's own time step", "all contacts of case 1",
        "itself"),
    Row("case_friction", "Dry contact", "friction of sliding spheres", "all sizes of case 1, on a wall", "itself"),
    Row("buck", "Single wet collisions", "restitution of a wet wall impact (Buck et al. 2018)",
        "1.74 mm glass, 100 µm of water",
        "impact velocity"),
    Row("davis_pair", "Single wet collisions", "restitution of two wet spheres, head on (Davis 2023)", "St 6 to 24",
        "impact velocity"),
    Row("davis_three", "Single wet collisions", "final velocities of three wet spheres (Davis 2023)", "St 12, 30°",
        "largest velocity"),
    Row("retained_dry", "Beds and screening", "fraction retained over time", "dry case, several seeds", "whole feed"),
    Row("end_height", "Beds and screening", "spheres at the end of screening: mean height", "dry case, several seeds",
        "itself"),
    Row("end_neighbours", "Beds and screening", "spheres at the end of screening: neighbours in touch",
        "dry case, several seeds", "itself"),
    Row("bed_dry_height", "Beds and screening", "settled bed: mean height", "dry bed, several seeds", "itself"),
    Row("bed_moist_height", "Beds and screening", "settled bed: mean height", "moist bed, several seeds", "itself"),
    Row("bed_dry_contacts", "Beds and screening", "settled bed: contacts per sphere", "dry bed, several seeds",
        "itself"),
    Row("bed_moist_contacts", "Beds and screening", "settled bed: contacts per sphere", "moist bed, several seeds",
        "itself"),
)  # fmt: skip
GROUPS = (
    "Capillary force", "Viscous forces", "Rupture", "Liquid", "Conserved", "Dry contact", "Single wet collisions",
    "Beds and screening",
)  # fmt: skip
ROWS = tuple(sorted([*_rows(), *OTHERS], key=lambda r: GROUPS.index(r.group)))
BY_KEY = {r.key: r for r in ROWS}
NO_MIGRATION = "Debian's build of YADE has no liquid migration: a bridge's volume is a property of the material"
SAME = "without liquid it is the same program and contact as LIGGGHTS"
NO_LOG = "the stock model keeps no log of its bridges, so there is nothing to replay"
REPLAY_REASONS = {
    EXACT: "no exact solution of this quantity is known; the reference recomputes the law from the papers",
    YADE: NO_MIGRATION,
    WASHINO: NO_LOG,
    EASO: NO_LOG,
}
"""Reasons why the replayed rows have only two columns."""
STOCK_MODEL_REASONS = {
    "viscous_normal": {YADE: "the capillary laws of YADE's ViscElCapMat have no viscous force of the liquid"},
    "viscous_tangential": {YADE: "the capillary laws of YADE's ViscElCapMat have no viscous force of the liquid"},
    "torque": {YADE: "its bridges exert no torque"},
    "force": {c: "measured at set gaps in the rows `capillary force over gap`" for c in (YADE, WASHINO, EASO)},
    "rupture_static": {c: "measured in the rows `rupture distance`" for c in (YADE, WASHINO, EASO)},
    "rupture_dynamic": {c: "its rupture distance does not depend on the speed" for c in (YADE, WASHINO, EASO)},
}
"""More specific reasons for some quantities."""
