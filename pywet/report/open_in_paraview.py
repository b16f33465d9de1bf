"""Show a run of pywet in ParaView: spheres by film thickness, bridges as cuboids, walls, curves.

In ParaView choose File, Load State and this file; or use `paraview --script=open_in_paraview.py`. For a picture
without a window: `pvbatch open_in_paraview.py OUT.png [TIME]`. Written by `pywet view RUN --paraview`; it may be
moved together with the files next to it.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from paraview import simple as pv

SHOWN: dict[str, Any] = {}
HERE = Path(__file__).resolve().parent if "__file__" in globals() else Path(SHOWN["folder"])
BLUES = (0.0, "#f3f7fb", 0.25, "#b5d3ea", 0.5, "#5b9fd0", 0.75, "#1d66ac", 1.0, "#08306b")
PLAIN = [None, ""]
"""Colouring by no array; `ColorBy(look, None)` fails for an empty source."""
INK = [0.15, 0.2, 0.24]


def rgb(text: str) -> list[float]:
    """Convert a colour #rrggbb to three numbers from 0 to 1."""
    return [int(text[k : k + 2], 16) / 255.0 for k in (1, 3, 5)]


def series(kind: str) -> Any:
    """Load one time series under its own name."""
    return pv.PVDReader(registrationName=kind, FileName=str(HERE / f"{kind}.pvd"))


def spheres(view: Any) -> Any:
    """Show spheres at their size, coloured by film thickness in µm."""
    film = pv.Calculator(registrationName="film in µm", Input=series("particles"))
    film.Function, film.ResultArrayName = "1e6*film_thickness", "film thickness in µm"
    balls = pv.Glyph(registrationName="spheres", Input=film, GlyphType="Sphere")
    balls.GlyphType.Radius, balls.GlyphType.ThetaResolution, balls.GlyphType.PhiResolution = 1.0, 24, 24
    balls.GlyphMode, balls.ScaleFactor = "All Points", 1.0
    balls.ScaleArray, balls.OrientationArray = ["POINTS", "radius"], ["POINTS", "No orientation array"]
    look = pv.Show(balls, view)
    look.Specular, look.SpecularPower = 0.35, 20
    if not SHOWN["moist"]:
        look.ColorArrayName = PLAIN
        look.DiffuseColor = rgb("#d9d3c7")
        return balls
    pv.ColorBy(look, ("POINTS", "film thickness in µm"))
    table = pv.GetColorTransferFunction("film thickness in µm")
    table.ColorSpace = "RGB"
    table.RGBPoints = [
        value
        for at, text in zip(BLUES[::2], BLUES[1::2], strict=True)
        for value in (at * SHOWN["thickest_um"], *rgb(text))
    ]
    bar = pv.GetScalarBar(table, view)
    bar.Title, bar.ComponentTitle, bar.TitleColor, bar.LabelColor = "film thickness in µm", "", INK, INK
    look.SetScalarBarVisibility(view, True)
    return balls


def bridges(view: Any) -> Any:
    """Show bridges as cuboids; they can be coloured by volume, separation, capillary_force, age, i and j."""
    every, made = series("cuboids"), []
    pv.Hide(every, view)
    for name, others in (("bridges", 1), ("bridges at large walls", 0)):
        some = pv.Threshold(registrationName=name, Input=every)
        some.Scalars, some.LowerThreshold, some.UpperThreshold, some.Invert = ["CELLS", "partner_kind"], 1, 1, others
        look = pv.Show(some, view)
        look.ColorArrayName = PLAIN
        look.DiffuseColor = look.AmbientColor = rgb("#e4572e")
        made.append(some)
    pv.Hide(made[1], view)  # they would appear to float in front of the translucent walls
    return made


def walls(view: Any) -> None:
    """Show every wall under its own name."""
    every = series("walls")
    pv.Hide(every, view)
    for name, wall in SHOWN["walls"].items():
        part = pv.Threshold(registrationName=name, Input=every)
        part.Scalars, part.LowerThreshold, part.UpperThreshold = ["CELLS", "reservoir"], wall["code"], wall["code"]
        look = pv.Show(part, view)
        look.ColorArrayName = PLAIN
        look.Opacity = wall["opacity"] or 0.15
        look.DiffuseColor = rgb("#9aa3ab" if wall["opacity"] == 1.0 else "#b9c4cf")
        if not wall["opacity"]:
            pv.Hide(part, view)


def curves(chart: dict[str, Any]) -> Any:
    """Show one table as curves in a separate view."""
    view = pv.CreateView("XYChartView")
    table = pv.CSVReader(registrationName=Path(chart["file"]).name, FileName=[str(HERE / chart["file"])])
    look = pv.Show(table, view, "XYChartRepresentation")
    names = chart["curves"]
    look.UseIndexForXAxis, look.XArrayName, look.SeriesVisibility = 0, chart["time"], list(names)
    look.SeriesLabel = [text for name, (label, _) in names.items() for text in (name, label)]
    look.SeriesColor = [text for name, (_, colour) in names.items() for text in (name, *map(str, rgb(colour)))]
    look.SeriesLineThickness = [text for name in names for text in (name, "2")]
    view.LeftAxisTitle, view.BottomAxisTitle, view.ChartTitle = chart["title"], "time in s", ""
    view.LeftAxisTitleFontSize = view.BottomAxisTitleFontSize = 13
    view.LegendLocation, view.LegendFontSize = chart["legend"], 10
    return view


def scene() -> tuple[Any, Any]:
    """Show everything in one layout; return the view of the scene and the layout."""
    view = pv.GetActiveViewOrCreate("RenderView")
    layout = pv.GetLayout(view) or pv.CreateLayout(SHOWN["name"])
    spheres(view)
    if SHOWN["moist"]:
        bridges(view)
    if SHOWN["walls"]:
        walls(view)
    message = pv.AnnotateTimeFilter(registrationName="time", Input=pv.FindSource("particles"))
    message.Format = f"{SHOWN['name']}   t = {{time:.3f}} s"
    text = pv.Show(message, view)
    text.Color, text.FontSize, text.WindowLocation = INK, 16, "Upper Left Corner"
    view.UseColorPaletteForBackground, view.Background, view.OrientationAxesLabelColor = 0, [0.96, 0.965, 0.97], INK
    camera = SHOWN["camera"]
    view.CameraPosition, view.CameraFocalPoint, view.CameraViewUp = camera["position"], camera["aim"], camera["up"]
    view.CameraViewAngle, view.CenterOfRotation = camera["angle"], camera["turn_about"]
    if SHOWN["charts"]:
        free = layout.SplitHorizontal(0, 0.66) + 1
        for k, chart in enumerate(SHOWN["charts"], start=1):
            cell = layout.SplitVertical(free, 0.5) if k < len(SHOWN["charts"]) else free
            free = cell + 1
            layout.AssignView(cell, curves(chart))
    pv.SetActiveView(view)
    return view, layout


def at_time(time: float) -> None:
    """Set the animation to a time."""
    animation = pv.GetAnimationScene()
    animation.UpdateAnimationUsingDataTimeSteps()
    animation.AnimationTime = time


if SHOWN:
    VIEW, LAYOUT = scene()
    at_time(SHOWN["time"])
    if len(sys.argv) > 1 and sys.argv[1].endswith(".png"):
        at_time(float(sys.argv[2]) if len(sys.argv) > 2 else SHOWN["time"])
        LAYOUT.SetSize(1500, 860)
        pv.SaveScreenshot(sys.argv[1], LAYOUT, ImageResolution=[1500, 860])
    else:
        pv.Render(VIEW)
