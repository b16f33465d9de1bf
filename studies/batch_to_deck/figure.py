"""Draw the figure of docs/screens.md from docs/batch_to_deck.csv: `python -m studies.batch_to_deck.figure [FOLDER]`.

With a folder of tables of `pywet kinetics BATCH... --deck DECK --out FOLDER/NAME.csv` these are stored in docs/batch_to_deck.csv
first: `batch` and the variants of `variants.py` (three seeds each), and deck.yaml.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pandas as pd

from pywet.errors import border
from pywet.report.pictures import COLOURS, STYLE, plt
from studies.batch_to_deck.variants import VARIANTS

ROOT = Path(__file__).resolve().parents[2]
STORED, FIGURE = ROOT / "docs" / "batch_to_deck.csv", ROOT / "docs" / "pictures" / "batch_to_deck.svg"
APERTURE_MM = 5.0
WAYS = {
    "plug_flow": "batch, plug flow",
    "residence_times": "batch, residence times",
    "crowded": "crowded",
    "travelling": "travelling",
    "travelling_crowded": "both",
}
"""Column of the table and its name on the page; variants with residence times."""
DRAWN = ("residence_times", "travelling")


def stored(folder: Path) -> pd.DataFrame:
    """Return the table of the batch with the predictions of its variants as further columns."""
    table = pd.read_csv(folder / "batch.csv")
    for variant in VARIANTS:
        other = pd.read_csv(folder / f"{variant}.csv").set_index("class").loc[table["class"]]
        for end in ("", "_half"):
            table[f"{variant}{end}"] = other[f"residence_times{end}"].to_numpy()
    return table


def page_rows(table: pd.DataFrame) -> list[str]:
    """Rows of the table of docs/screens.md: shares to the overs in per cent."""
    found = ["| d/a | " + " | ".join(WAYS.values()) + " | simulated |", "|---" * (2 + len(WAYS)) + "|"]
    for row in table.to_dict("records"):
        cells = [f"{100 * row[way]:.0f} ± {100 * row[f'{way}_half']:.0f}" for way in WAYS]
        simulated = f"{100 * row['T']:.0f} ({100 * row['T_low']:.0f} – {100 * row['T_high']:.0f})"
        found.append(f"| {row['diameter_mm'] / APERTURE_MM:g} | " + " | ".join([*cells, simulated]) + " |")
    return found


def draw(table: pd.DataFrame) -> None:
    """Draw predicted and simulated partition curves."""
    ratio = table["diameter_mm"].to_numpy(dtype=float) / APERTURE_MM
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(figsize=(4.8, 3.2), constrained_layout=True)
        t, low, high = (100.0 * table[c].to_numpy(dtype=float) for c in ("T", "T_low", "T_high"))
        axes.errorbar(
            ratio, t, np.maximum([t - low, high - t], 0.0), marker="o", color=COLOURS[0], capsize=2, label="simulated"
        )
        for k, way in enumerate(DRAWN, start=1):
            mean, half = (100.0 * table[c].to_numpy(dtype=float) for c in (way, f"{way}_half"))
            label = f"predicted, {WAYS[way]}"
            axes.errorbar(ratio + 0.008 * k, mean, half, marker="s", ls="--", color=COLOURS[k], capsize=2, label=label)
        axes.set(xlabel="diameter over aperture [-]", ylabel="to the overs [%]", ylim=(-3, 103))
        axes.legend(fontsize="small")
        FIGURE.parent.mkdir(exist_ok=True)
        figure.savefig(FIGURE, metadata={"Date": None})
        plt.close(figure)


if __name__ == "__main__":
    with border():
        if len(sys.argv) > 1:
            stored(Path(sys.argv[1])).to_csv(STORED, index=False, float_format="%.4g", lineterminator="\n")
        draw(pd.read_csv(STORED))
        print("\n".join(page_rows(pd.read_csv(STORED))))
        print(FIGURE.relative_to(ROOT))
