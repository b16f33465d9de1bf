"""Raw logs to tables in blocks of records, and tables read back part by part: the same as at once, however they are cut."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pywet import run_folder
from pywet.engines.liggghts import collecting, windows
from pywet.engines.run_store import forget
from pywet.runs import tables
from pywet.schema import RAW
from pywet.util.files import read_parts, read_table, write_parts
from tests.error_codes import raises_code

RANKS = 2


def raw(folder: Path, count: int = 400) -> None:
    """Logs of two ranks; one has steps that the other lacks, and none is in the order within a step that tables have."""
    random = np.random.default_rng(1)
    for name in tables.SORT:
        for rank in range(RANKS):
            records = np.zeros(count + 100 * rank, RAW[name])
            for field in records.dtype.names or ():
                kind = records[field].dtype.kind
                shape = records[field].shape
                records[field] = random.integers(0, 50, shape) if kind == "i" else random.random(shape)
            records[np.argsort(records["step"], kind="stable")].tofile(folder / f"{name}.{rank}.bin")


def at_once(folder: Path, name: str) -> pd.DataFrame:
    """All records of all ranks, sorted."""
    records = [np.fromfile(folder / f"{name}.{rank}.bin", RAW[name]) for rank in range(RANKS)]
    return tables.to_frame(np.concatenate(records)).sort_values(tables.SORT[name], kind="stable", ignore_index=True)


def convert(folder: Path, block: int = tables.BLOCK) -> None:
    """Write the tables of all logs into `history`."""
    for name, rows in tables.converted(folder, block):
        tables.write(rows, folder / "history" / f"{name}.parquet")


@pytest.mark.parametrize("block", [1, 7, 1000, tables.BLOCK])
def test_blocks_give_the_whole(tmp_path: Path, block: int) -> None:
    """Steps of some ten records a rank, so that blocks of 1 and 7 end within a step."""
    raw(tmp_path)
    convert(tmp_path, block)
    for name in tables.SORT:
        pd.testing.assert_frame_equal(
            pd.read_parquet(tmp_path / "history" / f"{name}.parquet"), at_once(tmp_path, name), check_exact=True
        )


@pytest.mark.parametrize("far", [0, 1 << 40, 1 << 62])
def test_records_are_put_in_order_by_two_numbers(far: int) -> None:
    """Also where one number made of both would be between the largest with and without a sign."""
    records = np.zeros(3, [("step", np.int64), ("i", np.int64)])
    records["step"], records["i"] = (far, 0, far), (0, 2, 1)
    wanted = np.lexsort((records["i"], records["step"]))
    assert (tables.in_order(records, ("step", "i")) == records[wanted]).all()


@pytest.mark.parametrize("far", [0, 1 << 40])
def test_records_are_put_in_order(far: int) -> None:
    """By one number made of all columns, and by these one after the other where that would be too large."""
    random = np.random.default_rng(2)
    records = np.zeros(1000, RAW["events"])
    for name in tables.SORT["events"]:
        records[name] = random.integers(0, 4, 1000)
    records["step"] += far * random.integers(0, 2, 1000)
    records["j"][0], records["i"][0], records["speed"] = 2**31 - 1, 2**31 - 1, random.random(1000)
    wanted = np.lexsort([records[name] for name in reversed(tables.SORT["events"])])
    assert (tables.in_order(records, tables.SORT["events"]) == records[wanted]).all()


def test_empty_logs_give_empty_tables(tmp_path: Path) -> None:
    """With all columns."""
    for name in tables.SORT:
        (tmp_path / f"{name}.0.bin").touch()
    convert(tmp_path)
    events = read_table(tmp_path / "history" / "events.parquet")
    assert len(events) == 0 and {"step", "volume", "speed"} <= set(events)
    (part,) = read_parts(tmp_path / "history" / "events.parquet", ["step", "volume"])
    assert len(part) == 0 and list(part) == ["step", "volume"]


def test_a_log_out_of_order_is_refused(tmp_path: Path) -> None:
    """As are records that are cut."""
    raw(tmp_path)
    path = tmp_path / "films.0.bin"
    records = np.fromfile(path, RAW["films"])
    records[::-1].tofile(path)
    with raises_code("run.order"):
        convert(tmp_path, 100)
    path.write_bytes(records.tobytes()[:-1])
    with raises_code("run.cut_off"):
        convert(tmp_path)


def test_trajectory_frame_by_frame(tmp_path: Path) -> None:
    """From file to file what it is at once; a part ends with a frame."""
    frames = [
        f"ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\nITEM: ATOMS id\n"
        + "".join(f"{i} 1 " + " ".join([f"{step + 0.1 * i:.17g}"] * 9) + "\n" for i in (1, 2))
        for step in range(0, 50, 10)
    ]
    path = tmp_path / "trajectory.txt"
    path.write_text("".join(frames))
    whole = pd.concat(collecting.trajectory_parts(path, 1e-3), ignore_index=True)
    assert len(whole) == 10 and whole["x"].iloc[-1] == 40.2
    parts = list(windows.dump_parts(path, collecting.TRAJECTORY, most_bytes=1))
    assert [part["step"].unique().tolist() for part in parts] == [[0], [10], [20], [30], [40]]
    tables.write(collecting.trajectory_parts(path, 1e-3), tmp_path / "trajectory.parquet")
    pd.testing.assert_frame_equal(read_table(tmp_path / "trajectory.parquet"), whole, check_exact=True)


def test_parts_are_refused_as_tables_are(tmp_path: Path) -> None:
    """A column that is not there, a number that is none, a bit that was flipped."""
    path = tmp_path / "history" / "films.parquet"
    good = pd.DataFrame({"step": np.arange(1000), "id": 1, "film": np.random.default_rng(1).random(1000)})
    write_parts([good[:500], good[500:]], path)
    assert [len(part) for part in read_parts(path, ["step", "film"], rows=300)] == [300, 200, 300, 200]
    assert list(read_table(path, step=700)["film"]) == [good["film"][700]]
    with raises_code("file.no_column", key="thickness"):
        list(read_parts(path, ["thickness"]))
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(bytes(content))
    with raises_code("file.no_table"):
        list(read_parts(path, ["step", "id", "film"]))
    write_parts([good.assign(film=np.nan)], path)
    with raises_code("file.not_finite", key="film"):
        list(read_parts(path, ["film"]))


def test_nothing_of_an_earlier_run_is_left(tmp_path: Path) -> None:
    """Files and folders that a run makes; what it starts from stays."""
    made = [
        "trajectory.parquet",
        "summary.json",
        "history/events.parquet",
        "history/window_states.parquet",
        "results/checks.json",
    ]
    stored = ["scene.json", "history/spheres.parquet", "stl/wires.stl"]
    run_folder.claim(tmp_path)
    run_folder.record(tmp_path, [*made, *stored])
    for name in [*made, *stored]:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).touch()
    forget(tmp_path)
    assert not any((tmp_path / name).exists() for name in made)
    assert all((tmp_path / name).exists() for name in stored)
