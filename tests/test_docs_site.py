"""The documentation builds as a site without a warning: all pages are in it, links lead somewhere, notebooks run."""

from __future__ import annotations

import html
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html", "-d", str(out / "trees")]
    done = subprocess.run(
        [*command, "docs", str(out / "html")], cwd=ROOT, env={**os.environ, "PYTHONPATH": str(ROOT)},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-3000:]
    return out / "html"


def test_every_page_is_in_the_site(site: Path) -> None:
    pages = {path.stem for path in (ROOT / "docs").glob("*.md")} - {"README"}
    assert pages <= {path.stem for path in site.glob("*.html")}


def test_the_notebook_printed_what_it_shows(site: Path) -> None:
    """The plan's table and a drawing are in the page: its blocks were executed."""
    text = (site / "first-steps.html").read_text()
    assert "tangential_history" in text and ".png" in text
    angle = re.search(r"angle of the bed (\d+) ± (\d+)°", text)
    assert angle is not None and 20 < int(angle[1]) < 90  # wet beads: steeper than dry ones, no ring along the wall
    assert "has a turning wall; expected a heap at rest around an upright axis: use drum_angle()" in text


def test_every_key_of_the_configuration_is_in_the_reference(site: Path) -> None:
    text = (site / "configuration_reference.html").read_text()
    for path in (ROOT / "workflow" / "schemas").glob("*.schema.json"):
        schema = json.loads(path.read_text())
        groups = [schema, *(g for g in schema.get("$defs", {}).values() if "properties" in g)]
        for key in (key for group in groups for key in group["properties"]):
            assert f">{key}<" in text, f"{path.name}: {key}"


def test_the_public_names_are_documented(site: Path) -> None:
    import pywet

    text = (site / "api.html").read_text()
    assert [name for name in pywet.__all__ if f">{name}<" not in text] == []


def test_every_key_of_a_scene_is_in_the_reference(site: Path) -> None:
    import pywet

    text = (site / "scene_reference.html").read_text()
    models = [c for c in (getattr(pywet, name) for name in pywet.__all__) if hasattr(c, "model_fields")]
    assert [k for c in models for k in c.model_fields if f">{k}<" not in text] == []
    assert ">contact_statistics<" in (site / "api.html").read_text()  # attribute of a run


def test_every_column_and_code_is_in_the_reference(site: Path) -> None:
    from pywet.schema import CODES, TABLES, meanings

    text = html.unescape((site / "columns.html").read_text()).replace("’", "'")
    reported = [reported for table in TABLES for _, reported in meanings(table).values()]
    assert len(reported) > 100 and [t for t in reported if t not in text] == []
    assert [t for rows in CODES.values() for t in rows.values() if t not in text] == []
