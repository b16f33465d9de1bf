"""Finding laws: by name, from a file, from an installed package; what does not exist is answered with what does."""

import os
import subprocess
import sys
from importlib import import_module
from importlib.metadata import EntryPoint
from pathlib import Path

import pytest

from pywet.config import EffectSettings
from pywet.laws import custom_laws as files
from pywet.laws import force_law, registry
from pywet.laws.kinds import KINDS, SWITCHED
from tests.error_codes import raises_code
from tests.import_graph import ROOT

CUSTOM_LAW = """
from pywet.laws.force_law import force_law

@force_law
def steady(speed, viscosity, surface_tension):
    return 1.25 + 0.0 * speed

@force_law
def moving(separation, radius_i, radius_j, viscosity):
    return 2.0 * viscosity

@force_law
def turning(separation, radius_i, radius_j, viscosity):
    return 3.0 * viscosity

both = (moving, turning)

def undecorated(speed, viscosity, surface_tension):
    return 1.0
"""


@pytest.fixture
def law_file(tmp_path: Path) -> Path:
    path = tmp_path / "my_laws.py"
    path.write_text(CUSTOM_LAW)
    files.trust([f"{path}:steady"])
    return path


def test_built_in_laws_of_each_kind() -> None:
    expected = {
        "capillary": ["rabinovich"],
        "viscous_normal": ["pitois"],
        "viscous_tangential": ["goldman"],
        "rupture": ["willett_unequal"],
        "dynamic_rupture": ["pitois"],
        "formation": ["shi_mccarthy"],
        "transfer": ["parabola"],
        "shedding": ["tate"],
    }
    assert set(expected) == set(KINDS)
    for kind, some in expected.items():
        assert set(some) <= set(registry.names(kind))
        law = registry.get(kind, some[0])
        assert (law.kind, law.name, len(law.functions)) == (kind, some[0], len(KINDS[kind].parts))


def test_law_from_a_file(law_file: Path) -> None:
    assert registry.get("dynamic_rupture", f"{law_file}:steady").functions[0](1.0, 1.0, 1.0) == 1.25
    pair = registry.get("viscous_tangential", f"{law_file}:both").functions
    assert [f(0.0, 1.0, 1.0, 5.0) for f in pair] == [10.0, 15.0]


@pytest.mark.parametrize(
    ("kind", "name", "code"),
    [
        ("capillary", "nonsense", "law.not_of_kind"),
        ("colour", "red", "law.kind"),
        ("capillary", "nowhere.py:law", "law.no_file"),
        ("dynamic_rupture", "{law_file}:absent", "law.no_function"),
        ("dynamic_rupture", "{law_file}:undecorated", "law.not_decorated"),
        (
            "capillary",
            "{law_file}:steady",
            "law.arguments",
        ),
        ("viscous_tangential", "{law_file}:moving", "law.functions"),
        ("transfer", "{law_file}:steady", "law.not_custom"),
    ],
)
def test_wrong_names_are_answered_in_one_sentence(law_file: Path, kind: str, name: str, code: str) -> None:
    with raises_code(code) as refusal:
        registry.get(kind, name.format(law_file=law_file))
    assert "\n" not in str(refusal.value)


def test_file_that_cannot_be_read_as_python(tmp_path: Path) -> None:
    path = tmp_path / "broken.py"
    path.write_text("def law(:\n")
    files.trust([f"{path}:law"])
    with raises_code("law.raises"):
        registry.get("capillary", f"{path}:law")


def test_a_file_that_changes_in_a_session_is_another_law(law_file: Path) -> None:
    """It has to be named again, and then the present text applies."""
    name = f"{law_file}:steady"
    assert registry.get("dynamic_rupture", name).functions[0](1.0, 1.0, 1.0) == 1.25
    law_file.write_text(CUSTOM_LAW.replace("1.25", "1.5"))
    with raises_code("law.untrusted"):
        registry.get("dynamic_rupture", name)
    files.trust([name])
    assert registry.get("dynamic_rupture", name).functions[0](1.0, 1.0, 1.0) == 1.5


IMPORTED = """
from parts import part
from pywet.laws.force_law import force_law

@force_law
def law(speed, viscosity, surface_tension):
    return part() + 0.0 * speed
"""


def test_a_law_of_a_package_is_compiled_in_each_process(tmp_path: Path) -> None:
    """numba's cache compares the file of the law itself, not those of the functions that it calls."""
    (tmp_path / "imported.py").write_text(IMPORTED)
    environment = {
        **os.environ, "PYTHONPATH": f"{tmp_path}:{ROOT}", "PYWET_CACHE": str(tmp_path / "cache"), "PYTHONDONTWRITEBYTECODE": "1"
    }  # fmt: skip
    for value in (1.25, 1.5):
        (tmp_path / "parts.py").write_text(f"import numba\n\n@numba.njit\ndef part():\n    return {value}\n")
        command = [sys.executable, "-c", "import imported; print(imported.law(1.0, 1.0, 1.0))"]
        done = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)
        assert float(done.stdout) == value


def test_published_laws(law_file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Laws of installed packages: listed under the kind whose arguments they have; a broken one is refused when asked for."""
    monkeypatch.syspath_prepend(str(law_file.parent))
    points = [
        EntryPoint("published_steady", "my_laws:steady", registry.GROUP),
        EntryPoint("published_broken", "no_such_package:law", registry.GROUP),
    ]
    monkeypatch.setattr(registry, "published", lambda: points)
    assert registry.names("dynamic_rupture") == ["pitois", "published_steady"]
    assert {"published_steady", "published_broken"}.isdisjoint(registry.names("capillary"))
    assert registry.get("dynamic_rupture", "published_steady").functions[0](0.0, 1.0, 1.0) == 1.25
    with raises_code("law.package", given="published_broken"):
        registry.get("capillary", "published_broken")


SENSELESS = """
from pywet.laws.force_law import force_law

@force_law
def pushing(separation, volume, radius_i, radius_j, contact_angle_i, contact_angle_j, surface_tension):
    return -surface_tension * radius_i

@force_law
def driving(separation, volume, radius_i, radius_j, normal_velocity, viscosity):
    return viscosity * radius_i * normal_velocity

@force_law
def slippery(separation, radius_i, radius_j, viscosity):
    return -viscosity * radius_i

@force_law
def turning(separation, radius_i, radius_j, viscosity):
    return -viscosity * radius_i

both = (slippery, turning)

@force_law
def never(volume, radius_i, radius_j, contact_angle_i, contact_angle_j):
    return 0.0 * volume

@force_law
def shorter(speed, viscosity, surface_tension):
    return 0.99 + 0.0 * speed

@force_law
def share(film_volume_i, radius_i, radius_j):
    return 1.0

@force_law
def share_wire(film_volume_i, radius_i, half_width):
    return 0.1 * film_volume_i

@force_law
def wall(film_thickness, radius_i):
    return film_thickness * radius_i**2

@force_law
def wire(film_thickness, radius_i, half_width):
    return film_thickness * radius_i * half_width

takes_all = (share, share_wire, wall, wire)
"""


@pytest.mark.parametrize(
    ("kind", "name", "says"),
    [
        (
            "capillary",
            "pushing",
            "pushing gives -3.64e-05 at .*expected a force of 0 or more while the bridge is short",
        ),
        ("viscous_normal", "driving", "driving gives .*expected a force against the velocity"),
        ("viscous_tangential", "both", "slippery gives .*expected a coefficient of 0 or more"),
        ("rupture", "never", "never gives 0 at .*expected a distance above 0"),
        ("dynamic_rupture", "shorter", "shorter gives 0.99 at .*expected a factor of 1 or more"),
        ("formation", "takes_all", "share gives 1 at film_volume_i=0.*expected a volume from 0 to that of the film"),
    ],
)
def test_a_law_that_cannot_be_meant_is_refused(tmp_path: Path, kind: str, name: str, says: str) -> None:
    """A force that repels or drives, a bridge that breaks at once, more liquid than there is: one sentence with the point."""
    path = tmp_path / "senseless.py"
    path.write_text(SENSELESS)
    files.trust([f"{path}:{name}"])
    with raises_code("law.value", says=says) as refusal:
        registry.get(kind, f"{path}:{name}")
    assert "senseless.py" in str(refusal.value) and "\n" not in str(refusal.value)


NAMED = """
from pywet.laws.force_law import force_law

@force_law("dynamic_rupture")
def calm(speed, viscosity, surface_tension):
    return 1.5 + 0.0 * speed

@force_law("viscous_tangential", "both_ways")
def sliding(separation, radius_i, radius_j, viscosity):
    return 2.0 * viscosity

@force_law("viscous_tangential", "both_ways")
def spinning(separation, radius_i, radius_j, viscosity):
    return -3.0 * viscosity
"""


def test_a_law_makes_itself_known(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """By its kind, in a module that is imported; functions of one name are one law; a name is given once."""
    monkeypatch.setattr(registry, "REGISTERED", {kind: dict(laws) for kind, laws in force_law.REGISTERED.items()})
    monkeypatch.setattr(force_law, "REGISTERED", registry.REGISTERED)
    monkeypatch.syspath_prepend(str(tmp_path))
    (tmp_path / "named_laws.py").write_text(NAMED)
    import_module("named_laws")
    assert registry.names("dynamic_rupture") == ["calm", "pitois"]
    assert registry.get("dynamic_rupture", "calm").functions[0](0.0, 1.0, 1.0) == 1.5
    pair = registry.get("viscous_tangential", "both_ways").functions
    assert [f(0.0, 1.0, 1.0, 5.0) for f in pair] == [10.0, -15.0]
    (tmp_path / "named_again.py").write_text(NAMED)
    with raises_code("law.name_taken", given="calm"):
        import_module("named_again")
    (tmp_path / "named_badly.py").write_text(NAMED.replace("dynamic", "static"))
    with raises_code("law.kind", given="static_rupture"):
        import_module("named_badly")
    registry._found.cache_clear()


def test_a_file_may_name_the_kind_too(tmp_path: Path) -> None:
    path = tmp_path / "named_laws.py"
    path.write_text(NAMED)
    files.trust([f"{path}:calm"])
    assert registry.get("dynamic_rupture", f"{path}:calm").functions[0](0.0, 1.0, 1.0) == 1.5
    assert "calm" not in registry.names("dynamic_rupture")


def test_every_kind_has_its_switch_unless_no_bridge_is_without_it() -> None:
    assert {*SWITCHED, "shedding"} == {*KINDS} & {*EffectSettings.model_fields}  # no preset has shedding
    assert {kind for kind in KINDS if kind not in SWITCHED} == {"rupture", "formation", "transfer", "shedding"}


def test_every_built_in_kind_that_a_user_may_write_has_a_sense() -> None:
    assert all(kind.parts[0].sense for name, kind in KINDS.items() if name != "transfer")
