"""Format the answer of `pywet calibrate`: JSON, readable sentences, a figure of responses, targets and likelihoods."""

from __future__ import annotations

import hashlib
import json
import math
import os
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from pywet import run_folder
from pywet.calibration import question as asking
from pywet.calibration.experiments import Experiment
from pywet.calibration.inference import MISFIT
from pywet.calibration.question import Question
from pywet.calibration.search import Found, Runs, find
from pywet.compare.statistics import half_width
from pywet.errors import PywetError
from pywet.util.files import make_folder, read_if_there, write_json

ALIKE = 5
"""Number of points reported along a direction of zero slope."""


def calibrate(
    file: Path, folder: Path, ranks: int = 1, say: Callable[[str], None] = lambda line: None
) -> dict[str, Any]:
    """Calibrate according to a file; write `calibration.json` and `calibration.svg` next to the runs and return the answer."""
    from pywet.calibration import figure

    question, experiments = asking.read(file)
    make_folder(folder)
    with run_folder.hold_part(folder, "calibrate"):
        found = find(question, experiments, folder, ranks, say)
        answer = {"question": fingerprint(question, experiments), **described(question, found)}
        if found.runs is not None:
            answer["runs"] = _runs(question, found)
            answer["check"] = _check(question, experiments, found, found.runs)
        answer["sentences"] = sentences(question, answer)
        _rename_another(folder, answer["question"], say)
        write_json(folder / "calibration.json", answer)
        figure.draw(question, found, folder / "calibration.svg")
    return answer


def fingerprint(question: Question, experiments: Sequence[Experiment]) -> str:
    """Return the digest of a calibration: its file, the contents of its targets' files, and the files that these name."""
    content = [question.model_dump_json(), *(json.dumps(e.content, sort_keys=True, default=str) for e in experiments)]
    settings = question.settings(np.zeros(len(question.parameters)))
    content += [digest for e in experiments for digest in e.digests(settings)]
    return hashlib.sha256("\n".join(content).encode()).hexdigest()[:16]


def _rename_another(folder: Path, question: str, say: Callable[[str], None]) -> None:
    """Rename a stored answer to another question, or an unreadable one, before the new answer is written."""
    path = folder / "calibration.json"
    try:
        stored = read_if_there(path, shape=dict[str, Any])
    except PywetError:
        stored = {}
    if stored is None or stored.get("question") == question:
        return
    free = next(k for k in range(1, 10**6) if not os.path.lexists(folder / f"calibration.{k}.json"))
    for kind in ("json", "svg"):
        old = folder / f"calibration.{kind}"
        if os.path.lexists(old):
            old.rename(folder / f"calibration.{free}.{kind}")
    say(f"{path} answered another question, and is calibration.{free}.json from now on")


def described(question: Question, found: Found) -> dict[str, Any]:
    """List parameters with their intervals, targets with the values reached, and indistinguishable parameters."""
    solved, names = found.problem, list(question.parameters)
    mean, variance, _ = solved.response(solved.best)
    parameters = {}
    for k, (name, p) in enumerate(question.parameters.items()):
        ranges = [{**asdict(r), "low": p.at(r.low), "high": p.at(r.high)} for r in solved.intervals(k)]
        parameters[name] = {"best": p.at(float(solved.best[k])), "intervals": ranges, "bounds": [p.low, p.high]}
    groups = solved.unknown()
    return {
        "name": question.name,
        "confidence": question.confidence,
        "parameters": parameters,
        "targets": [
            {
                "quantity": t.quantity, "value": t.value, "standard_error": t.error,
                "response": float(m), "response_standard_error": float(np.sqrt(v)),
            }
            for t, m, v in zip(question.targets, mean, variance, strict=True)
        ],
        "reached": solved.reached,
        "not_told_apart": [{"parameters": [names[k] for k in g], "alike": _alike(question, found, g)} for g in groups],
        "stopped": found.stopped,
    }  # fmt: skip


def _alike(question: Question, found: Found, group: list[int]) -> list[dict[str, float]]:
    """Return values of all parameters that fit equally well, along the first parameter of the group."""
    solved, k = found.problem, group[0]
    span = solved.intervals(k)[0]
    places = [solved.profile(k, float(at))[1] for at in np.linspace(span.low, span.high, ALIKE)]
    return [question.values(place) for place in places]


def _runs(question: Question, found: Found) -> dict[str, Any]:
    """Return all engine runs, and the properties of the response fitted to those inside the window."""
    assert found.runs is not None and found.surface is not None
    rows = [
        {"seed": k, **question.values(place), "values": value.tolist()}
        for k, (place, value) in enumerate(zip(found.runs.places, found.runs.values, strict=True))
    ]
    return {
        "count": len(rows), "seconds": float(np.sum(found.runs.seconds)), "deviation": found.surface.deviation.tolist(),
        "freedom": found.surface.freedom, "misfit": found.surface.misfit, "rows": rows,
    }  # fmt: skip


def _check(question: Question, experiments: list[Experiment], found: Found, runs: Runs) -> list[dict[str, Any]]:
    """Run new seeds at the answer and return the mean and its interval for each target that depends on the seed."""
    n = question.check_runs
    values = np.array([runs.measure(found.problem.best, question.most_runs + k)[0] for k in range(n)])
    targets = [t for t, e in zip(question.targets, experiments, strict=True) if e.random_start]
    return [
        {
            "quantity": t.quantity, "runs": n, "mean": float(v.mean()),
            "half_width": half_width(float(v.std(ddof=1)), n, n - 1, question.confidence),
        }
        for t, v in zip(targets, values.T, strict=True)
    ]  # fmt: skip


def sentences(question: Question, answer: dict[str, Any]) -> list[str]:
    """Write the answer of a calibration as sentences: best values, intervals, parameters that cannot be distinguished."""
    sure, lines = f"{100 * question.confidence:g} %", []
    for name, reported in answer["parameters"].items():
        ranges = " or ".join(f"{r['low']:.4g} to {r['high']:.4g}" for r in reported["intervals"])
        lines.append(f"{name}: {reported['best']:.4g} ({sure}: {ranges})")
        bounds = dict(zip(("low", "high"), reported["bounds"], strict=True))
        ends = [(bounds[side], r[side]) for side in bounds for r in reported["intervals"] if r[f"open_{side}"]]
        at_bounds = [f"{bound:g}" for bound, end in ends if math.isclose(bound, end, rel_tol=1e-6, abs_tol=1e-12)]
        cut_off = [f"{end:.4g}" for bound, end in ends if not math.isclose(bound, end, rel_tol=1e-6, abs_tol=1e-12)]
        if at_bounds:
            lines.append(
                f"{name} ends at {' and '.join(at_bounds)} because that is its bound, not because the targets say so"
            )
        if cut_off:
            lines.append(
                f"{name} is cut off at {' and '.join(cut_off)}, where the last round of runs ended: raise most_runs"
            )
    for t in answer["targets"]:
        lines.append(
            f"{t['quantity']}: wanted {t['value']:.5g} ± {t['standard_error']:.2g}, "
            f"the best gives {t['response']:.5g} ± {t['response_standard_error']:.2g} (standard errors)"
        )
    if not answer["reached"]:
        lines.append(
            "no values between the bounds reproduce the targets: fix the bounds, or doubt experiment and model"
        )
    lines += [_unknown(group) for group in answer["not_told_apart"]]
    if "runs" in answer:
        lines += _of_runs(answer)
    return lines


def _unknown(group: dict[str, Any]) -> str:
    """List the parameters that the targets do not determine, alone or together."""
    names = group["parameters"]
    if len(names) == 1:
        return f"{names[0]} cannot be determined: the targets hardly depend on it; give a target that does, or fix it"
    pairs = [", ".join(f"{v:.4g}" for name, v in row.items() if name in names) for row in group["alike"]]
    return (
        f"{' and '.join(names)} cannot be distinguished by these targets: ({'), ('.join(pairs)}) fit alike; "
        "give one more target that depends on them in another way, or fix one"
    )


def _of_runs(answer: dict[str, Any]) -> list[str]:
    """Return the lines on the number of runs, the reason for stopping, the scatter of the seeds and the check."""
    runs = answer["runs"]
    scatter = ", ".join(f"{d:.2g}" for d in runs["deviation"])
    lines = [
        f"{runs['count']} runs, {runs['seconds']:.0f} s; stopped as {answer['stopped']}; a single run scatters by {scatter}"
    ]
    if runs["misfit"] < MISFIT:
        lines.append("the runs do not follow the polynomial through them: narrower bounds would make the answer safer")
    for c in answer["check"]:
        lines.append(
            f"{c['runs']} fresh seeds with the best values: {c['quantity']} {c['mean']:.5g} ± {c['half_width']:.2g}"
        )
    return lines
