"""Movie of a run: an MP4 and a short loop, rendered off screen, with the curves of `caption.curves` over time.

The camera and the colours are the same in all frames. Frames are drawn in a child process, like pictures (`render.py`).
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from pywet.errors import FileError, PywetError, arguments, border, shown
from pywet.report import caption, render
from pywet.report.pictures import colours
from pywet.report.sketch import colour_limit
from pywet.runs.rundir import Floats, RunDir
from pywet.util.files import atomic_write

SIZE = (560, 480)
CHART = 220
"""Width of the curves next to the scene, in pixels."""
LINES = ("#0b3c78", "#5d8a3a", "#8b5fa5", "#c0392b")
"""Colours of the curves and of their titles."""
PER_SECOND = 12
LOOP = 24
"""Number of frames of the loop."""


def write(run_dir: Path, frames: int = 48, progress: Callable[[float], None] = lambda share: None) -> list[Path]:
    """Write movie.mp4 and the loop movie.webp of a run and return both."""
    run = RunDir(Path(run_dir))
    _ffmpeg()  # checked before the work starts
    with tempfile.TemporaryDirectory() as folder:
        for share in render.in_child("pywet.report.movie", str(run.path), folder, str(frames)):
            progress(float(share))
        pictures = [Image.open(path).convert("RGB") for path in sorted(Path(folder).glob("*.png"))]
        return [_mp4(pictures, run.path / "movie.mp4"), _loop(pictures, run.path / "movie.webp")]


def spread(count: int, most: int) -> list[int]:
    """Choose at most a given number of `count` indices, evenly spaced, with the first and the last."""
    return [int(k) for k in np.unique(np.linspace(0, count - 1, min(most, count)).round())]


def draw(run: RunDir, frames: int, folder: Path) -> None:
    """Draw every frame as a PNG file in this process and print the finished share."""
    line = run.timeline
    rows = spread(len(line.steps), frames)
    seen = render.view(run, render.telling_step(run))
    limit = max(colour_limit(run, int(line.steps[row])) for row in rows)
    curves = caption.curves(run)
    for k, row in enumerate(rows):
        step = int(line.steps[row])
        image, mm = render.scene(run, step, seen, limit, SIZE, fine=False)
        whole = np.asarray(image)[..., :3]
        if curves:
            whole = np.concatenate([whole, chart(line.times, curves, row)], axis=1)
        caption.save(
            caption.below(whole, caption.entries(run), caption.sentence(run, step), mm), folder / f"{k:05d}.png"
        )
        print((k + 1) / len(rows), flush=True)


def chart(times: Floats, curves: Sequence[caption.Curve], row: int) -> Any:
    """Return the curves up to a row of the table, on axes of the whole run, as pixels."""
    picture = Image.new("RGB", (CHART, SIZE[1]), caption.PAPER)
    pen, font = ImageDraw.Draw(picture), ImageFont.load_default(12)
    left, right, top, bottom = 40, CHART - 14, 28 + 16 * len(curves), SIZE[1] - 60
    x = left + (right - left) * times / times[-1]
    pen.line([(left, top), (left, bottom), (right, bottom)], fill=caption.SOFT)
    for value in (0.0, 0.5, 1.0):
        place = (left - 6, bottom - (bottom - top) * value)
        pen.text(place, f"{value:g}", fill=caption.INK, font=font, anchor="rm")
    pen.text((left, bottom + 8), "0", fill=caption.INK, font=font)
    pen.text((right, bottom + 8), f"{times[-1]:.3g} s", fill=caption.INK, font=font, anchor="ra")
    drawn = [(bottom - (bottom - top) * curve.values, colour)
             for curve, colour in zip(curves, colours(len(curves), LINES), strict=True)]  # fmt: skip
    points = [list(zip(x.tolist(), y.tolist(), strict=True)) for y, _ in drawn]
    for of_curve in points:
        pen.line(of_curve, fill="#dfe4e9", width=2)
    for k, ((y, colour), of_curve) in enumerate(zip(drawn, points, strict=True)):
        pen.text((left - 30, 12 + 16 * k), curves[k].title, fill=colour, font=font)
        pen.line(of_curve[: row + 1], fill=colour, width=3)
        pen.ellipse([x[row] - 5, y[row] - 5, x[row] + 5, y[row] + 5], fill="#d98032")
    return np.asarray(picture)


def _ffmpeg() -> Any:
    try:
        import imageio_ffmpeg
    except ImportError as error:
        raise PywetError(
            "movies need imageio-ffmpeg, which is not installed: pip install pywet[movie]", code="movie.no_ffmpeg"
        ) from error
    return imageio_ffmpeg


def _mp4(pictures: list[Image.Image], path: Path) -> Path:
    wide, high = (length // 2 * 2 for length in pictures[0].size)  # the codec requires even sizes
    with atomic_write(path) as temporary:
        how = {"fps": PER_SECOND, "macro_block_size": 2, "ffmpeg_log_level": "quiet", "output_params": ["-f", "mp4"]}
        writer = _ffmpeg().write_frames(str(temporary), (wide, high), **how)
        writer.send(None)
        for picture in pictures:
            writer.send(np.ascontiguousarray(np.asarray(picture)[:high, :wide, :3]))
        writer.close()
        _refuse_cut_off(temporary, len(pictures), path)
    return path


def _refuse_cut_off(made: Path, frames: int, path: Path) -> None:
    """Read the result of ffmpeg again, because ffmpeg does not report a full disk."""
    try:
        found, _ = _ffmpeg().count_frames_and_secs(str(made))
    except (OSError, RuntimeError):
        found = 0
    if found != frames:
        raise FileError(
            f"{shown(path)} could not be written completely ({found} of {frames} frames); expected a writable folder with "
            "free space",
            path=path, code="movie.cut_off", given=found, expected=frames,
        )  # fmt: skip


def _loop(pictures: list[Image.Image], path: Path) -> Path:
    first, *rest = [pictures[k] for k in spread(len(pictures), LOOP)]
    with atomic_write(path) as temporary:
        first.save(
            temporary, format="WEBP", save_all=True, append_images=rest, duration=2000 // PER_SECOND, loop=0, quality=70
        )
    return path


if __name__ == "__main__":
    with border():
        run_dir, out, frames = arguments(RUN_DIR=Path, OUT=Path, FRAMES=int)
        draw(RunDir(run_dir), frames, out)
