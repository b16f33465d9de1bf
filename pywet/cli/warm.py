"""Machine code made ahead, which the first question of each kind would otherwise wait for; `make setup` calls it.

Each kind of question is asked once, so that whatever it compiles is kept. Quick where that is done.
"""

from __future__ import annotations

from collections.abc import Callable

from pywet import machine_code
from pywet.errors import border


def _laws() -> None:
    """What the engine is given of each law."""
    from pywet.engines.liggghts.plugin_api import in_use
    from pywet.laws import registry

    for kind, laws in registry.BUILT_IN.items():
        for name in laws:
            for function in in_use(registry.get(kind, name)):
                _ = function.address


def _bridge() -> None:
    from pywet.bench.bridge_query import Query, answer

    body = {"radius_m": 2e-3, "contact_angle_deg": 20}
    given = {"bodies": [body, body], "volume_m3": 1e-10, "surface_tension_N_per_m": 0.07, "separations_m": [0.0, 1e-4]}
    answer(Query.model_validate(given))


def _wall() -> None:
    from pywet.collisions.wall import curves, wall

    wall.collide(curves.problem("glass_1.74mm", ("water", 100)))


def _spheres() -> None:
    from pywet.collisions.spheres.command import collide

    collide({"form": "three_equal_spheres", "St_n": 12, "t_end": 4})


QUESTIONS: dict[str, Callable[[], None]] = {
    "force laws": _laws,
    "one bridge": _bridge,
    "a sphere and a wall": _wall,
    "wet spheres": _spheres,
}


def main() -> None:
    """Ask what has not been asked with these sources on this processor."""
    for name, ask in () if machine_code.ready() else QUESTIONS.items():
        print(f"machine code, once for this processor: {name}", flush=True)
        ask()
    machine_code.mark()


if __name__ == "__main__":
    with border():
        main()
