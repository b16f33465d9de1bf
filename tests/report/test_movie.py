"""The movie and what is below a picture, looked at by numbers."""

from __future__ import annotations

from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image

from pywet.report import caption, movie
from pywet.runs.rundir import RunDir
from tests.error_codes import raises_code


def test_frames_are_evenly_spread_from_the_first_to_the_last() -> None:
    assert movie.spread(81, 5) == [0, 20, 40, 60, 80] and movie.spread(3, 48) == [0, 1, 2]


def test_the_dot_stands_at_the_time_and_the_fraction_retained() -> None:
    """Half of the time, a quarter retained: the middle of the dot is there on axes from (40, 420) to (206, 44)."""
    retained = caption.Curve("fraction_retained_spheres", "fraction retained (spheres)", np.array([1.0, 0.25, 0.0]))
    pixels = movie.chart(np.array([0.0, 1.0, 2.0]), [retained], 1)
    rows, columns = np.nonzero((pixels == (0xD9, 0x80, 0x32)).all(axis=2))
    assert (columns.mean(), rows.mean()) == pytest.approx(((40 + 206) / 2, 420 - 0.25 * 376), abs=1.0)


@pytest.mark.parametrize(("scale", "width"), [(7.3, 146), (3000.0, 150)])
def test_the_scale_bar_is_as_long_as_it_says(scale: float, width: int) -> None:
    """At 7.3 pixels a millimetre 20 mm are 146 pixels, at most a fifth of 900; at 3000 of them 0.05 mm are 150."""
    picture = caption.below(np.full((400, 900, 3), 255, dtype=np.uint8), [("#ff0000", "red things")], "", scale)
    pixels = np.asarray(picture)[400:]
    dark = (pixels == (0x27, 0x32, 0x3D)).all(axis=2)
    bar = dark[:, 900 - 14 - width - 3 :]  # right of its text
    assert int(bar.sum(axis=1).max()) == pytest.approx(width, abs=3)
    assert (pixels == (255, 0, 0)).all(axis=2).any()


def test_caption_of_a_moment(run: Path) -> None:
    """At step 100 one of two spheres of 2 mm is in the bin, next to one of 4 mm: 9 of 10 parts of the mass are retained."""
    assert caption.sentence(RunDir(run), 100) == "case02   t = 0.010 s   retained 90.0 % of the spheres' mass"
    assert [text for _, text in caption.entries(RunDir(run))] == [
        "spheres, darker where their film is thicker", "liquid bridges", "wires",
    ]  # fmt: skip


def test_the_movie_has_every_output_and_its_loop_too(run: Path) -> None:
    shares: list[float] = []
    video, loop = movie.write(run, progress=shares.append)
    assert shares == pytest.approx([1 / 3, 2 / 3, 1.0])
    count, seconds = imageio_ffmpeg.count_frames_and_secs(str(video))
    assert count == 3 and seconds == pytest.approx(3 / movie.PER_SECOND, abs=0.01)
    with Image.open(loop) as frames:
        assert (frames.n_frames, frames.info["loop"], frames.format) == (3, 0, "WEBP")
        seen = []
        for k in range(3):
            frames.seek(k)
            seen.append(np.asarray(frames.convert("RGB"), dtype=float)[: movie.SIZE[1], : movie.SIZE[0]])
    # spheres leave the picture one after the other: less blue in each frame
    blue = [np.mean(frame[..., 2] - frame[..., 0] > 40) for frame in seen]
    assert blue[0] > blue[1] > blue[2] > 0


def test_without_a_codec_the_message_names_what_to_install(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "imageio_ffmpeg", None)
    with raises_code("movie.no_ffmpeg"):
        movie.write(run)
