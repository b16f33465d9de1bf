"""The script for ParaView, run by ParaView's own pvbatch where that is installed (Debian: paraview, xvfb); skipped elsewhere."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from PIL import Image

from pywet import stages
from pywet.report import paraview, vtk
from pywet.runs.rundir import RunDir
from tests.cases.screening import synthetic

LOOK = """
import json, runpy, sys
sys.argv = ["open_in_paraview.py", {picture!r}, "0.02"]
runpy.run_path({script!r}, run_name="__main__")
from paraview import simple as pv
from paraview import servermanager

def seen(name):
    source = pv.FindSource(name)
    source.UpdatePipeline(0.02)
    known = source.GetDataInformation()
    return {{"cells": known.GetNumberOfCells(), "bounds": list(known.GetBounds())}}

names = ["spheres", "bridges", "bridges at large walls", "wires", "side_wall", "collecting_bin"]
seen_here = {{name: seen(name) for name in names}}
whole = pv.IntegrateVariables(Input=pv.FindSource("cuboids"))
whole.UpdatePipeline(0.02)
seen_here["volume"] = servermanager.Fetch(whole).GetCellData().GetArray("Volume").GetValue(0)
seen_here["times"] = list(pv.FindSource("particles").TimestepValues)
(chart,) = [view for view in pv.GetViews() if view.GetXMLName() == "XYChartView"]
seen_here["curves"] = list(pv.GetDisplayProperties(pv.FindSource("fraction_retained.csv"), chart).SeriesVisibility)
print("SEEN", json.dumps(seen_here))
"""


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = synthetic.make(tmp_path_factory.mktemp("runs") / "case02")
    curve = pd.DataFrame({"step": synthetic.STEPS, "time_s": [0.0, 0.01, 0.02], "fraction_retained": [1.0, 0.9, 0.8]})
    (folder / "results").mkdir()
    curve.to_csv(folder / "results" / "fraction_retained.csv", index=False)
    stages.vtk(folder, paraview=True)
    return folder


def test_the_script_knows_its_run(run: Path) -> None:
    shown = paraview.shown(RunDir(run))
    assert [(name, wall["code"]) for name, wall in shown["walls"].items()] == [
        ("wires", 0), ("side_wall", 1), ("collecting_bin", 2),
    ]  # fmt: skip
    assert shown["time"] == 0.01  # a third of what passes has passed
    assert [list(chart["curves"]) for chart in shown["charts"]] == [["fraction_retained"]]
    text = (run / "vtk" / "open_in_paraview.py").read_text()
    assert paraview.EMPTY in paraview.SCRIPT.read_text() and paraview.EMPTY not in text
    assert compile(text, "open_in_paraview.py", "exec")


@pytest.mark.skipif(
    shutil.which("pvbatch") is None, reason="ParaView's pvbatch is not installed: apt-get install paraview"
)
@pytest.mark.skipif(
    not os.environ.get("DISPLAY") and shutil.which("xvfb-run") is None,
    reason="ParaView draws on a screen only: apt-get install xvfb",
)
def test_paraview_shows_spheres_bridges_walls_and_curves(run: Path, tmp_path: Path) -> None:
    picture = tmp_path / "paraview.png"
    look = tmp_path / "look.py"
    look.write_text(LOOK.format(picture=str(picture), script=str(run / "vtk" / "open_in_paraview.py")))
    # VTK opens the screen, closes it and opens it again: without -noreset the server starts again between the two
    # and refuses about one in seventy
    screen = [] if os.environ.get("DISPLAY") else ["xvfb-run", "-a", "-s", "-screen 0 1280x1024x24 -noreset"]
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    output_text = subprocess.run(
        [*screen, "pvbatch", str(look)], env=environment, capture_output=True, text=True, check=False
    )
    line = next((text for text in output_text.stdout.splitlines() if text.startswith("SEEN ")), None)
    assert line is not None, output_text.stderr[-2000:]
    reported = json.loads(line.removeprefix("SEEN "))
    assert reported["times"] == [0.0, 0.01, 0.02] and reported["curves"] == ["fraction_retained"]
    # at 0.02 s: 4 mm around (-6, 0, 6) mm, 2 mm around (0, 0, -50) and (6, 0, -50); facets lie inside their sphere
    np.testing.assert_allclose(reported["spheres"]["bounds"], np.array([-10, 8, -4, 4, -52, 10]) * 1e-3, atol=1e-4)
    # two bridges, one at a wire; no wall but the wire has any
    assert reported["bridges"]["cells"] == 2 and reported["bridges at large walls"]["cells"] == 0
    corners = vtk.cuboids(RunDir(run), 200).points.reshape(-1, 8, 3)
    edges = np.stack([corners[:, k] - corners[:, 0] for k in (1, 3, 4)], axis=1)
    assert reported["volume"] == pytest.approx(np.abs(np.linalg.det(edges)).sum(), rel=1e-6)
    # wires and side walls have risen by 2 mm, the bin has not
    heights = [reported[name]["bounds"][4] for name in ("wires", "side_wall", "collecting_bin")]
    np.testing.assert_allclose(heights, [2e-3, 2e-3, -0.06], atol=1e-6)
    pixels = np.asarray(Image.open(picture).convert("RGB"), dtype=float)
    scene = pixels[:, : int(0.6 * pixels.shape[1])]
    assert np.mean(scene[..., 2] - scene[..., 0] > 40) > 0.002  # blue spheres
    assert np.mean(scene[..., 0] - scene[..., 2] > 60) > 0.0001  # red bridges
