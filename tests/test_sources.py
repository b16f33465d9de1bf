"""One list says which source files a run follows from; every fingerprint of a run is made of it."""

from __future__ import annotations

from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from pywet import scene_stages
from pywet.calibration import experiments
from pywet.cases.custom.description import Scene
from pywet.cases.screening import identity
from pywet.cases.small import small
from pywet.engines import run_store
from pywet.engines.liggghts.build import SOURCES as PLUGIN
from pywet.laws import registry
from pywet.util import sources
from tests.cases.custom.conftest import beads
from tests.cases.screening import synthetic
from tests.import_graph import ROOT, modules


def reached(start: set[str]) -> set[str]:
    """Modules that are imported by some, directly or not."""
    graph, found = modules(), set(start)
    while new := set().union(*(graph[name] for name in found)) - found:
        found |= new
    return found


def test_a_run_goes_through_no_file_that_is_not_in_the_list() -> None:
    """Driver and worker of every engine, with all that they import; the plugin; the templates of the script."""
    drivers = {f"pywet.engines.{e}.{m}" for e in ("liggghts", "lammps", "yade") for m in ("driver", "worker")}
    names = {
        name.replace(".", "/")
        for name in reached({*drivers, "pywet.engines.yade.in_yade", "pywet.engines.yade.memory"})
    }
    listed = {str(path.relative_to(ROOT)) for path in sources.of_a_run()}
    assert {name for name in names if not {f"{name}.py", f"{name}/__init__.py"} & listed} == set()
    assert {str(p.relative_to(ROOT)) for p in PLUGIN.iterdir() if p.suffix in (".cpp", ".h")} <= listed
    assert {str(p.relative_to(ROOT)) for p in (ROOT / "liggghts_inputs").glob("*.j2")} <= listed


def test_an_evaluation_goes_through_no_file_that_is_not_in_a_list() -> None:
    """Building, results, checks and replay; what the configuration's reader and the planned cost give is in the scene."""
    cases, scenes = ("pywet.cases.screening.", "pywet.cases.custom.")
    names = {f"{cases}cases", f"{cases}results", f"{cases}verdict", f"{scenes}building", f"{scenes}results"}
    names |= {
        "pywet.products.screening_report",
        "pywet.products.until",
        "pywet.planning.audit",
        "pywet.cases.script.folder",
    }
    found = {ROOT / f"{name.replace('.', '/')}.py" for name in reached(names)}
    listed = {path.resolve() for path in (*sources.of_a_run(), *sources.of(sources.EVALUATION))}
    missing = {path.relative_to(ROOT).parts[1] for path in found if path.exists() and path not in listed}
    assert missing <= {"config"}
    assert {*(ROOT / "reference_impl").rglob("*.py")} <= listed


def test_checkpoints_identities_and_calibrations_change_with_the_list(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (file := tmp_path / "law.py").write_text("one")

    def prints() -> list[str]:
        sources.digest_of_a_run.cache_clear()
        made = run_store.fingerprint(tmp_path, synthetic.scene()), identity.of({"name": "scene"})
        return [*made, str(experiments._program.__wrapped__())]

    monkeypatch.setattr(sources, "of_a_run", lambda: [file])
    before = prints()
    assert prints() == before
    file.write_text("two")
    assert all(one != other for one, other in zip(prints(), before, strict=True))
    sources.digest_of_a_run.cache_clear()


def test_runs_with_the_law_of_a_package_change_with_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Any of its files counts, as a module of the law may import it; runs without its laws stay the same."""
    (tmp_path / "published_package").mkdir()
    (tmp_path / "published_package" / "__init__.py").touch()
    monkeypatch.syspath_prepend(str(tmp_path))
    points = (EntryPoint("published_law", "published_package.laws:law", registry.GROUP),)
    monkeypatch.setattr(registry, "published", lambda: points)

    def prints(law: str) -> list[str]:
        registry._package_digest.cache_clear()
        described, scene = Scene(**beads(laws={"capillary": law})), synthetic.scene()
        scene = scene.model_copy(update={"effects": small.PAPER.model_copy(update={"capillary": law})})
        made = run_store.fingerprint(tmp_path, scene), identity.of({"law": law}), scene_stages.fingerprint(described)
        return [*made, experiments._name(described)]

    before, built_in = prints("published_law"), prints("willett")
    assert prints("published_law") == before
    (tmp_path / "published_package" / "parts.py").write_text("FACTOR = 2.0\n")
    assert all(one != other for one, other in zip(prints("published_law"), before, strict=True))
    assert prints("willett") == built_in
    registry._package_digest.cache_clear()
