"""What the package declares: every import is a dependency with a lower bound that the pinned versions satisfy, and no other."""

from __future__ import annotations

import ast
import re
import sys
import tomllib
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, metadata
from pathlib import Path

from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet
from packaging.version import Version

from tests.import_graph import ROOT

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
MODULE = {"pyyaml": "yaml", "ruamel.yaml": "ruamel", "pillow": "PIL", "imageio-ffmpeg": "imageio_ffmpeg"}
"""Package -> the module that it is imported by, where the names differ."""
NEVER_IMPORTED = {"snakemake", "jsonschema", "snakemake-executor-plugin-slurm", "pywet"}
"""Programs, and what they load."""
WITHOUT = {
    "cycler",
    "llvmlite",
    "pydantic_core",
    "vtkmodules",
    "paraview",
    "yade",
    "pywet",
    "reference_impl",
    "my_capillary",
    "studies",
}
"""Come with a dependency (matplotlib, numba, pydantic, pyvista), with another program that runs our file, or are our own."""


def imported(*folders: str) -> set[str]:
    """Modules from elsewhere that the files of folders import."""
    names = set()
    for path in (p for folder in folders for p in (ROOT / folder).rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Import):
                names |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                names.add(node.module.partition(".")[0])
    return names - set(sys.stdlib_module_names) - WITHOUT


def needs(*extras: str) -> dict[str, Requirement]:
    """Requirements of the package with extras, by name."""
    listed = [*PROJECT["dependencies"], *(r for e in extras for r in PROJECT["optional-dependencies"][e])]
    return {r.name: r for r in map(Requirement, listed)}


def test_what_is_imported_is_declared_and_the_other_way_round() -> None:
    declared = {MODULE.get(name, name) for name in needs("workflow", "movie", "cluster") if name not in NEVER_IMPORTED}
    assert imported("pywet", "reference_impl") == declared


def test_lower_bounds_are_met_by_the_pinned_versions() -> None:
    lines = (ROOT / "constraints.txt").read_text().splitlines()
    pinned = {re.sub(r"[-_.]+", "-", n).lower(): v for n, _, v in (line.partition("==") for line in lines)}
    for name, requirement in needs("workflow", "movie", "cluster").items():
        if name != "pywet":
            version = Version(pinned[re.sub(r"[-_.]+", "-", name).lower()])
            assert [s.operator for s in requirement.specifier] == [">="] and version in requirement.specifier, name


def test_every_pinned_version_runs_on_the_python_of_debian_12() -> None:
    """3.11.2, which set-up uses on a fresh machine, even where a later 3.11 is installed here."""
    lines = (ROOT / "constraints.txt").read_text().splitlines()
    wrong, seen = [], 0
    for name, _, version in (line.partition("==") for line in lines):
        with suppress(PackageNotFoundError):
            about = metadata(name)
            if about["Version"] == version:
                seen += 1
                if "3.11.2" not in SpecifierSet(about["Requires-Python"] or ""):
                    wrong.append(f"{name}=={version}: {about['Requires-Python']}")
    assert wrong == [] and seen > 0.9 * len(lines)


def test_the_version_is_the_same_everywhere() -> None:
    version = PROJECT["version"]
    assert f"version: {version}\n" in (ROOT / "CITATION.cff").read_text()
    assert f"## {version}" in (ROOT / "CHANGELOG.md").read_text()
    assert f"pywet-{version}-py3" in (ROOT / "README.md").read_text()


def test_the_container_installs_what_setup_installs() -> None:
    """Debian's packages of the two, and an extra that exists."""
    container, setup = ((ROOT / name).read_text() for name in ("Containerfile", "tools/setup"))
    wanted = [word for line in re.findall(r"^packages\+?=\(([^)]*)\)", setup, re.MULTILINE) for word in line.split()]
    assert len(wanted) > 10 and [word for word in wanted if word not in container.split()] == []
    extras = re.findall(r"/opt/pywet\[([\w,]+)\]", container)[0].split(",")
    assert set(extras) <= set(PROJECT["optional-dependencies"])
    assert Path(ROOT / ".github" / "workflows" / "test.yml").read_text().count("run: make test") == 1
