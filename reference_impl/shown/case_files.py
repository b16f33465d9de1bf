"""Files of the cases of a report: the engine's logs and results recomputed from them, by number or name of a case."""

from __future__ import annotations

import csv
import json
from collections.abc import Sequence
from functools import cache, cached_property
from pathlib import Path
from typing import Any

from reference_impl.replay.arrays import Floats
from reference_impl.replay.io import parquet_table

STAGES = ("scene", "simulate", "results", "replay", "vtk")
LOST = 1e-12
"""Share of the liquid beyond which it is not conserved."""
RETAINED = "results/fraction_retained.parquet"
BEGUN = (RETAINED, "status", "identity.json")
"""Paths of which a run that was begun has one."""


def name_of(number: int | str) -> str:
    """Return the folder of a case; for a case with another preset it is its name."""
    return f"case{number:02d}" if isinstance(number, int) else number


class Cases:
    """The listed cases in a folder; `table` is the list of all cases in CSV."""

    def __init__(self, folder: Path, table: Path, listed: Sequence[int]) -> None:
        self.folder, self.listed = folder, list(listed)
        with table.open() as lines:
            rows = csv.DictReader(line for line in lines if not line.startswith("#"))
            self.rows = {int(row["case"]): row for row in rows}
        self.column = cache(self._column)
        self.json = cache(self._json)

    def _json(self, number: int | str, name: str) -> Any:
        path = self.folder / name_of(number) / name
        return json.loads(path.read_text()) if path.exists() else None

    def summary(self, number: int | str) -> Any:
        """Return the content of summary.json of a case; None if there is none."""
        return self.json(number, "summary.json")

    @cached_property
    def config(self) -> Any:
        """Return the configuration of the first case that has one."""
        every = (self.json(n, "config.json") for n in self.listed)
        return next((config for config in every if config and "scale" in config), None)

    def configuration(self, number: int) -> str:
        """Return the values of a case except its liquid: material, sizes, aperture, amplitude, and the feed it has."""
        row = self.rows[number]
        feed = "".join(f" {float(row[key]):g}" for key in ("class_mass_g", "class_volume_cm3") if row.get(key))
        return f"{row['material']} {self.sizes(number)} {self.screen(number)}{feed}"

    def sizes(self, number: int) -> str:
        """Return the diameters of the classes of a case."""
        return "/".join(f"{float(self.rows[number][f'{c}_mm']):g}" for c in ("small", "near_mesh", "large"))

    def screen(self, number: int) -> str:
        """Return aperture and amplitude of a case."""
        return " ".join(f"{float(self.rows[number][f'{c}_mm']):g}" for c in ("aperture", "set_amplitude"))

    def liquid(self, number: int) -> float:
        """Return the per cent of liquid of a case."""
        return float(self.rows[number]["liquid_percent"] or 0.0)

    def liquid_name(self, number: int) -> str:
        """Return the name of the liquid that the list of cases gives for a moist case; empty if it gives none."""
        return (self.rows[number].get("liquid") or "") if self.liquid(number) else ""

    def by_liquid(self, numbers: Sequence[int]) -> list[list[int]]:
        """List the cases of each configuration and liquid by rising amount, each with the dry ones of the configuration."""
        groups = []
        for configuration in dict.fromkeys(map(self.configuration, numbers)):
            of = [n for n in numbers if self.configuration(n) == configuration]
            for name in dict.fromkeys(self.liquid_name(n) for n in of if self.liquid(n)) or [""]:
                alike = (n for n in of if not self.liquid(n) or self.liquid_name(n) == name)
                groups.append(sorted(alike, key=self.liquid))
        return groups

    def seeds(self, number: int | str) -> list[str]:
        """Return the folders of a case's further seeds that have a fraction retained."""
        return [seed for seed in self.begun(number) if self.retained(seed)]

    def begun(self, number: int | str) -> list[str]:
        """Return the folders of a case's further seeds, named CASE-SEED, the finished ones first.

        Not those that ran with another configuration, or for which a file or the program had changed by their fingerprints, nor
        those whose scene has the seed of the case or of a folder before.
        """
        name, mine, word = name_of(number), self._run_with(number), self._seedless(number)
        there = {path.name for part in BEGUN for path in self.folder.glob(f"{name}-*") if (path / part).exists()}
        seeds = sorted(folder for folder in there if folder.removeprefix(f"{name}-").isdigit())
        seeds.sort(key=self.retained, reverse=True)
        alike = [folder for folder in seeds if None in (mine, its := self._run_with(folder)) or its == mine]
        alike = [folder for folder in alike if None in (word, its := self._seedless(folder)) or its == word]
        used = [(self.json(run, "scene.json") or {}).get("seed") for run in (number, *alike)]
        return [folder for k, folder in enumerate(alike, start=1) if used[k] is None or used[k] not in used[:k]]

    def _seedless(self, number: int | str) -> str | None:
        """Return the fingerprint of a run that does not depend on its seed; None for a run without one."""
        found: str | None = (self.json(number, "identity.json") or {}).get("seedless")
        return found

    def _run_with(self, number: int | str) -> str | None:
        """Return the configuration of a run as text, apart from its seed, the number of seeds and of ranks."""
        found = self.json(number, "config.json")
        if found is None:
            return None
        rest = {k: v for k, v in found.get("settings", {}).items() if k not in ("seed", "seeds", "ranks")}
        return json.dumps({**found, "settings": rest}, sort_keys=True)

    def of_seeds(self, number: int | str, *keys: str, factor: float = 1.0) -> list[float]:
        """Return a number of summary.json by its keys, for a case and its further seeds; empty if the case has none."""
        values = [self.summary(run) for run in (number, *self.seeds(number))]
        for key in keys:
            values = [data.get(key) if data is not None else None for data in values]
        return [factor * v for v in values if v is not None] if values[0] is not None else []

    def wall_times(self, number: int | str) -> list[float]:
        """Return the wall time of a case and its further seeds, except of runs that were resumed."""
        found = [self.summary(run) for run in (number, *self.seeds(number))]
        return [data["wall_s"] for data in found if data is not None and not data.get("resumed_at_step")]

    def ends(self, number: int | str) -> list[float]:
        """Return the fraction retained at the end for every seed of a case."""
        tables = [parquet_table(self.folder / run / RETAINED) for run in self.seeds(number)]
        first = self.of_seeds(number, "fraction_retained_end")[:1]
        return first + [float(table["fraction_retained"].iloc[-1]) for table in tables]

    def dry_ends(self, number: int | str) -> list[float]:
        """Return the share of the mass of the spheres that is retained at the end, for every seed of a case."""
        runs = (self.folder / run / RETAINED for run in (name_of(number), *self.seeds(number)))
        return [float(parquet_table(path)["fraction_retained_spheres"].iloc[-1]) for path in runs]

    def retained(self, number: int | str) -> bool:
        """Return whether a case has the table of its fraction retained."""
        return (self.folder / name_of(number) / RETAINED).exists()

    def bridged(self, number: int) -> bool:
        """Return whether a case has bridges; for a case that was not run, whether it has liquid."""
        data = self.summary(number)
        return bool(data["effects"]["bridges"] if data else self.liquid(number))

    def quantities(self, number: int | str) -> dict[str, Any]:
        """List the quantities that the replay of a case compared."""
        return dict((self.json(number, "replay.json") or {"quantities": {}})["quantities"])

    def agrees(self, number: int | str) -> bool:
        """Return whether a case was replayed and nothing is beyond its limit."""
        rows = self.quantities(number).values()
        return bool(rows) and all(q["largest"] <= q["tolerance"] for q in rows)

    def results_are_last(self, number: int) -> bool:
        """Return whether the results of a case are those of its last run."""
        return bool((self.json(number, "status/results.json") or {"ok": False})["ok"])

    def done(self, number: int) -> bool:
        """Return whether every stage of a case succeeded and no check of the outcome of it and its further seeds fails."""
        runs: list[int | str] = [number, *self.begun(number)]
        return all(self._ended(run) and self._passed(run) for run in runs)

    def _ended(self, run: int | str) -> bool:
        """Return whether every stage of a run succeeded; a further seed may have no VTK files."""
        stages = {name: self.json(run, f"status/{name}.json") for name in STAGES}
        if isinstance(run, str) and stages["vtk"] is None:
            del stages["vtk"]
        return all(stage and stage["ok"] for stage in stages.values())

    def _passed(self, run: int | str) -> bool:
        """Return whether a run has results and no check of its outcome fails."""
        data = self.summary(run)
        if data is None:
            return False
        whole = data["ledger_error"] is None or data["ledger_error"] <= LOST
        replayed = self.agrees(run) or not (data["effects"]["bridges"] or self.quantities(run))
        return whole and replayed and all(c["ok"] for c in data["checks"])

    def _column(self, number: int | str, column: str) -> tuple[Floats, Floats] | None:
        """Return times and values of a column of a case; liquid in per cent of the initial liquid."""
        of_liquid = column.endswith("_m3")
        path = self.folder / name_of(number) / ("results/liquid_by_holder.parquet" if of_liquid else RETAINED)
        if not path.exists() or column not in (table := parquet_table(path)):
            return None
        y = 100.0 * table[column] / table["initial_m3"] if of_liquid else table[column]
        return table["time_since_opening_s"].to_numpy(float), y.to_numpy(float)
