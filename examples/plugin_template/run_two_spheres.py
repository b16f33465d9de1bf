"""Two spheres drawn apart inside LIGGGHTS with the law of this folder; prints force over separation, engine and Python."""

from __future__ import annotations

from pathlib import Path

from pywet.cases.small import bridge_engine, bridge_query
from pywet.laws import custom_laws, registry

HERE = Path(__file__).parent
LAW = f"{HERE / 'my_capillary.py'}:my_capillary"


def main() -> None:
    """Measure at a few separations and compare."""
    custom_laws.trust([LAW])
    given = bridge_query.read(HERE / "two_spheres.json").model_copy(update={"laws": (LAW, "pitois")})
    in_engine = bridge_engine.measured(given)["force_N"][LAW]
    law = registry.get("capillary", LAW).functions[0]
    print("separation [m]   engine [N]      Python [N]")
    for separation, force in zip(given.separations_m, in_engine, strict=True):
        python = law(separation, given.volume_m3, *given.pair, given.surface_tension_N_per_m)
        print(f"{separation:<16g} {'ruptured' if force is None else f'{force:.6e}':<15} {python:.6e}")


if __name__ == "__main__":
    main()
