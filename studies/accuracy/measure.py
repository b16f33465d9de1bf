"""One run of the accuracy study: prepared, timed, measured, and its run directory removed."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path

from pywet.cases.small import small
from pywet.cost.timing import timed
from pywet.engines.liggghts import driver
from pywet.engines.pipeline import RunInfo
from pywet.errors import PywetError
from studies.accuracy import bodies, sieve
from studies.accuracy.parameters import Setting, reference
from studies.accuracy.sieve import SCREENING
from studies.study import Row


def rows_of(
    scene: str, seed: int, parameter: str, setting: Setting, size: str, config_dir: Path, vary: sieve.Vary = lambda same: same
) -> list[Row]:  # fmt: skip
    """Execute a run and return a row, for colliding pairs one each; after a refusal or failure with the reason in `failed`.

    `vary` changes the inputs of a screening scene.
    """
    if scene == "laws":
        errors = {} if parameter == "transfer_nodes" else bodies.law_errors(setting)
        if parameter in ("default", "transfer_nodes"):
            errors |= bodies.sharing_error(setting, int(reference("transfer_nodes", size)))
        return [{**errors, "failed": None}]
    with tempfile.TemporaryDirectory(prefix="pywet-study-") as name:
        folder = Path(name)
        begin: Callable[[], RunInfo]
        try:
            if scene in SCREENING:
                sieve.prepare(folder, scene, setting, sieve.SIZES[size], seed, config_dir, vary)
                begin = lambda: driver.run(folder, setting.ranks, progress=False)  # noqa: E731
            else:
                spheres = bodies.prepare(scene, folder, setting, seed)
                begin = lambda: small.run(folder, spheres, setting.ranks)  # noqa: E731
            took = {**timed(folder, begin), "failed": None}
            measured = [sieve.quantities(folder)] if scene in SCREENING else bodies.quantities(scene, folder)
        except PywetError as error:
            return [{"failed": str(error).replace(name, "RUN_DIR")}]
    return [{**row, **took} for row in measured]
