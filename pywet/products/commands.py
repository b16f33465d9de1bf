"""What is asked of finished runs of screens: the functions of `import pywet`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pandas as pd

from pywet.products import kinetics as laws
from pywet.products import pages, screening_report


def screen(folder: Path | str, aperture_mm: float | None = None, from_s: float | None = None) -> dict[str, Any]:
    """Cut size, efficiency, throughput, moisture, pegging of a run; written to results/screen.json and screen.html too.

    Parameters
    ----------
    folder : Path or str
        Finished run of a screening case, or of a custom scene whose outlets are overs and unders.
    aperture_mm : float, optional
        Size that parts undersize from oversize; if not given that of the case or of the deck, else the cut size.
    from_s : float, optional
        Time from which means are taken; if not given, from where the run is steady.
    """
    numbers = screening_report.write(Path(folder), aperture_mm, from_s)
    pages.write(Path(folder), numbers)
    return numbers


def kinetics(folders: Sequence[Path | str]) -> pd.DataFrame:
    """Laws of the fraction retained over time, fitted to seeds of one case and ranked on those that were not fitted."""
    return laws.of_runs([Path(folder) for folder in folders])
