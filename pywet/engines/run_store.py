"""Files of an engine's run: `engine.partial` until it is complete, then `engine` and the tables.

A kill at any moment neither loses nor mixes data. Tables are made in `engine.partial/tables`, then those of an earlier
run are removed, the new ones are moved to their paths, `engine.partial` is renamed `engine`, and only then are the raw
files deleted. Until that renaming everything can be repeated from the raw files.

`engine.partial/fingerprint.json` identifies what is run; `finished.json` marks that the engine has finished, with the
sums of all logs. `engine/tables.json` lists the tables of the run, `engine/run.json` is its account.
"""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from typing import Any

from pywet import run_folder
from pywet.engines.liggghts import logs
from pywet.errors import PywetError
from pywet.laws import registry
from pywet.runs import tables
from pywet.scene import EngineScene
from pywet.schema import RAW
from pywet.util import sources
from pywet.util.file_list import remove
from pywet.util.files import read_json, write_json

CHECKPOINTS, TABLES = "checkpoint", "tables"
FINGERPRINT, FINISHED, INDEX, ACCOUNT = "fingerprint.json", "finished.json", "tables.json", "run.json"


OUTPUT = (
    "trajectory.parquet", "mesh_motion.parquet", *(f"history/{name}.parquet" for name in (*RAW, "window_*")), "replay.json",
    "contributions.json", "audit.json", "summary.json", "picture.png", "picture_*.png", "close_up_*.png", "movie.mp4",
    "movie.webp", "results", "vtk", "ovito", "engine.partial.new",
    *(f"status/{stage}.json" for stage in ("simulate", "replay", "results", "vtk")),
)  # fmt: skip
"""All tables of a run, by their paths in the run directory."""


def forget(run_dir: Path) -> None:
    """Remove the files of an earlier run from the directory, the list that marks a complete run first; other files remain."""
    run_folder.refuse_foreign(run_dir, "engine")
    remove(run_dir, "engine/tables.json")
    run_folder.remove_listed(run_dir, ("engine", *OUTPUT))


def fingerprint(run_dir: Path, scene: EngineScene, *parts: str) -> str:
    """Hash everything a run depends on: scene, spheres, walls, films, laws, program, and `parts` (plugin, deck lines)."""
    digest = hashlib.sha256()
    if scene.blocks:  # a run of more blocks resumes from the checkpoints of one of fewer
        digest.update(scene.of_blocks(1).model_dump_json().encode())
    files = [] if scene.blocks else [run_dir / "scene.json"]
    files.append(run_dir / scene.spheres_file)
    files += [run_dir / "history" / f"{name}.parquet" for name in ("spheres", "triangles")]
    files += [run_dir / wall.stl for wall in scene.walls]
    named = (law for law in scene.effects.model_dump().values() if isinstance(law, str))
    files += [Path(law.rpartition(":")[0]) for law in named if ".py:" in law]
    for path in files:
        digest.update(path.read_bytes() if path.is_file() else b"-")
    for part in (sources.digest_of_a_run(), registry.published_code(json.dumps(scene.effects.laws)), *parts):
        digest.update(b"\0" + part.encode())
    return digest.hexdigest()


class RunStore:
    """The files of the run with this fingerprint (`digest`) in a run directory; each JSON file is read once."""

    def __init__(self, run_dir: Path, digest: str) -> None:
        self.run_dir, self.digest = run_dir, digest
        self.partial, self.engine = run_dir / "engine.partial", run_dir / "engine"
        self.made = self.partial / TABLES

    @property
    def is_begun(self) -> bool:
        """Whether `engine.partial` holds a run with this fingerprint; it may come to."""
        path = self.partial / FINGERPRINT
        try:
            return bool(read_json(path, logs.UNREAD) == {"fingerprint": self.digest})
        except PywetError as error:
            logs.refuse_unread(path, error)
            return False

    @cached_property
    def _index(self) -> dict[str, Any]:
        """Content of tables.json; empty unless the finished run has this fingerprint."""
        path = self.engine / INDEX
        try:
            index = read_json(path, logs.UNREAD)
            return dict(index) if index["fingerprint"] == self.digest else {}
        except (PywetError, KeyError, TypeError) as error:
            logs.refuse_unread(path, error)
            return {}

    def account(self) -> dict[str, Any] | None:
        """Return run.json of the finished run if all its tables are unchanged; else None."""
        try:
            sums = logs.sums_of(self._index["files"])
        except (AttributeError, KeyError, TypeError, ValueError):
            return None
        return None if logs.damage(self.run_dir, sums) else dict(read_json(self.engine / ACCOUNT, "run the case again"))

    def finished(self) -> tuple[dict[str, Any] | None, str | None]:
        """Return the account of an engine that has finished with all its logs, else None; and a phrase if logs are damaged."""
        if not self.is_begun or not (self.partial / FINISHED).exists():
            return None, None
        try:
            end = logs.read_signed(self.partial / FINISHED)
            account, sums = dict(end["account"]), logs.sums_of(end["logs"])
        except (PywetError, AttributeError, KeyError, TypeError, ValueError) as error:
            logs.refuse_unread(self.partial / FINISHED, error)
            return None, f"its end ({FINISHED} is damaged)"
        broken = logs.damage(self.partial, sums)
        return (None, f"its end ({broken})") if broken else (account, None)

    @contextmanager
    def new(self) -> Iterator[Path]:
        """Yield an empty folder, which replaces `engine.partial` if nothing is raised."""
        ready = run_folder.make_folder(self.run_dir, f"{self.partial.name}.new")
        (ready / CHECKPOINTS).mkdir()
        write_json(ready / FINGERPRINT, {"fingerprint": self.digest})
        yield ready
        run_folder.refuse_foreign(self.run_dir, self.engine.name)
        run_folder.remove_folder(self.run_dir, self.partial.name)
        run_folder.rename_folder(self.run_dir, ready.name, self.partial.name)
        self.forget_other()

    def forget_other(self) -> None:
        """Remove the tables of a run with another fingerprint; raises if a file that no run wrote is among them."""
        run_folder.refuse_foreign(self.run_dir, self.engine.name)
        if not self._index:
            forget(self.run_dir)

    def disown(self) -> None:
        """Mark the folder so that the next call starts from the beginning, since its run cannot be resumed."""
        (self.partial / FINGERPRINT).unlink(missing_ok=True)

    def finish(self, sums: logs.Sums, account: dict[str, Any]) -> None:
        """Record that the engine has finished, so that only the collection of tables remains."""
        logs.write_signed(self.partial / FINISHED, {"logs": sums, "account": account})

    def reopen(self) -> None:
        """Make a finished run resume from its last checkpoint, to extend it."""
        (self.partial / FINISHED).unlink(missing_ok=True)

    def drop_tables(self) -> None:
        """Remove the tables of a collection that was stopped."""
        shutil.rmtree(self.made, ignore_errors=True)

    def put(self, name: str, rows: tables.Rows) -> None:
        """Write a table of a run that is to be published."""
        tables.write(rows, self.made / f"{name}.parquet")

    def publish(self, account: Mapping[str, Any]) -> None:
        """Publish a complete run: its tables replace an earlier run's, its folder is renamed, the raw files are deleted."""
        sums = {str(path.relative_to(self.made)): logs.checked(path) for path in sorted(self.made.rglob("*.parquet"))}
        write_json(self.partial / ACCOUNT, account)
        of_account = {f"{self.engine.name}/{ACCOUNT}": logs.checked(self.partial / ACCOUNT)}
        write_json(self.partial / INDEX, {"fingerprint": self.digest, "files": {**sums, **of_account}})
        run_folder.check_held(self.run_dir)
        forget(self.run_dir)
        for name in sums:
            (self.run_dir / name).parent.mkdir(exist_ok=True)
            run_folder.place(self.made / name, self.run_dir, name)
        shutil.rmtree(self.made)
        run_folder.publish(self.run_dir, self.partial.name, self.engine.name)
        self.tidy()

    def tidy(self) -> None:
        """Remove files that only an unfinished run needs; may be repeated."""
        shutil.rmtree(self.engine / CHECKPOINTS, ignore_errors=True)
        for path in (*logs.files(self.engine), self.engine / FINISHED, self.engine / FINGERPRINT):
            path.unlink(missing_ok=True)
