"""What the commands print of runs, and the few steps that several of them share."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from pywet.errors import PywetError
from pywet.files import read_if_there, read_json
from pywet.notices import bar

if TYPE_CHECKING:
    from pywet.bench.bridge_query import Query

out = Console(highlight=False)
err = Console(stderr=True, highlight=False)


def tell(line: object, style: str | None = None) -> None:
    """A line of the answer as it is: not wrapped, nothing in it marked up."""
    out.print(str(line), style=style, soft_wrap=True, markup=False)


def atlas(folder: Path, stock: bool, own: Sequence[str] = ()) -> Path:
    from pywet.evidence.atlas import page

    with bar("atlas") as move:
        return page.write_page(folder, lambda what, share: move(share, title=what), with_stock=stock, own=own)


def bridge_table(query: Query, answer: dict[str, Any]) -> None:
    """The answer of `pywet bridge` as tables, with what each law is off the exact bridge."""
    from pywet.bench import bridge_query
    from pywet.report import bridge

    for table in bridge.table(query.separations_m, answer, bridge_query.exact_force(query)):
        if table.row_count:
            out.print(table)


def bridge_plot(query: Query, answer: dict[str, Any], path: Path) -> None:
    """Force over gap up to the longest bridge; what an engine measured is drawn as points."""
    from pywet.bench import bridge_query
    from pywet.report import bridge

    longest = max(d for d in answer["rupture_distance_m"].values() if d is not None)
    gaps = tuple(longest * (k / 80.0) ** 2 for k in range(81))
    dense = query.model_copy(update={"separations_m": gaps})
    inside = (query.separations_m, answer) if "measured_in" in answer else None
    bridge.draw(path, bridge.figure(gaps, bridge_query.answer(dense), bridge_query.exact_force(dense), inside))


def movie(run_dir: Path) -> list[Path]:
    from pywet.report import movie as drawing

    with bar("movie") as move:
        return drawing.write(run_dir, progress=move)


def serve(server: Any) -> None:
    tell(f"{server.address} (Ctrl-C ends it)")
    with server:
        try:
            server.serve_forever()
        except KeyboardInterrupt:
            out.print("ended")


def say_time(config: Any, case: int, scale: str) -> None:
    """How long the run will take, where this machine has been measured (`pywet plan CASE --accuracy` does)."""
    from pywet.evidence.accuracy import command

    if said := command.predicted(config, case, scale):
        err.print(f"{config.case(case).name} at scale {scale}: {said}", soft_wrap=True)


def need_run(run_dir: Path) -> None:
    if not (run_dir / "scene.json").exists():
        raise PywetError(
            f"no scene.json in {run_dir}; expected a run directory as `pywet run CASE --out DIR` writes it"
        )


def stage(folder: Path, stage: str, work: Any) -> None:
    """Run a stage, leave its status, stop with its reason when it failed."""
    from pywet import stages

    status = stages.attempt(folder, stage, work, aloud=False)
    if not status.ok:
        raise PywetError(f"stage {status.failed_at} failed: {status.reason}")


def show_summary(folder: Path) -> None:
    """A few lines on a run; exit code 1 when its checks, ledger or replay object."""
    from pywet.runs.shapes import Summary
    from pywet.screening import verdict

    summary = read_json(folder / "summary.json", shape=Summary)
    out.print(
        f"{folder}: {sum(summary['spheres'].values())} spheres, {summary['steps']} steps in {summary['wall_s']:.1f} s",
        markup=False,
    )
    end, coarse = summary["fraction_retained_end"], summary["coarse_share"]
    out.print(f"fraction retained at the end {end:.3f} (share that cannot pass {coarse:.3f})")
    if summary["ledger_error"] is not None:
        out.print(f"liquid ledger off by {summary['ledger_error']:.1e} of the liquid put in")
    show_findings(folder)
    if objections := verdict.objections(folder):
        raise PywetError("; ".join(objections))


def show_seeds(folders: list[Path]) -> None:
    """What several seeds of a case say together: mean, spread and range of the fraction retained at the end."""
    from statistics import mean, stdev

    from pywet.runs.shapes import Summary

    ends = [read_json(folder / "summary.json", shape=Summary)["fraction_retained_end"] for folder in folders]
    out.print(
        f"{len(ends)} seeds: fraction retained at the end {mean(ends):.3f} ± {stdev(ends):.3f} (standard deviation of a run), "
        f"from {min(ends):.3f} to {max(ends):.3f}",
        soft_wrap=True,
    )


def show_run(folder: Path) -> None:
    """The same of a scene of one's own, which has been judged already."""
    from pywet.runs.shapes import RunSummary

    summary = read_json(folder / "summary.json", shape=RunSummary)
    out.print(f"{sum(summary['spheres'].values())} spheres, {summary['steps']} steps in {summary['wall_s']:.1f} s")
    for name, volume in summary["liquid_end_m3"].items():
        out.print(f"liquid at the end, {name:<24}{1e9 * volume:10.4g} mm3", markup=False)
    show_findings(folder)


def show_findings(run_dir: Path) -> None:
    """The laws of a run by kind (of one in a file the file's name), its effects, and what the replay found."""
    from pywet.runs.shapes import Replay
    from pywet.scene import Scene

    if laws := Scene.read(run_dir / "scene.json").effects.laws:
        tell("laws: " + ", ".join(f"{kind} {law.rpartition('/')[2]}" for kind, law in laws.items()))
    show_audit(run_dir)
    if replayed := read_if_there(run_dir / "replay.json", shape=Replay):
        show_agreement(replayed)


def show_audit(run_dir: Path) -> None:
    """What each effect contributed against the effect plan, where the run has both."""
    from pywet.planning import audit

    if rows := audit.read(run_dir):
        out.print("effects, plan against replay:")
        for line in audit.lines(rows):
            out.print(line, soft_wrap=True, highlight=False)


def show_agreement(replay_json: dict[str, Any]) -> None:
    """Agreement table; exit code 1 when a quantity is beyond its tolerance."""
    from pywet.screening import verdict
    from reference_impl.replay import whole

    table = Table("quantity", "values", "largest", "median", "", box=None, header_style="bold")
    rows = verdict.agreement(replay_json)
    for row in rows:
        said = "[green]agrees" if row.ok else "[red]disagrees"
        table.add_row(escape(row.quantity), str(row.count), f"{row.largest:.1e}", f"{row.median:.1e}", said)
    out.print(table)
    if "compared" in replay_json:
        out.print(whole.said(replay_json["compared"]), soft_wrap=True)
        for sentence in replay_json["not_checked"]:
            tell(f"not checked: {sentence}")
        for kind, function in (replay_json.get("second") or {}).items():
            tell(f"{kind}: held against {Path(function).name}, a second function of yours")
        for sentence in verdict.unchecked_laws(replay_json):
            tell(f"not checked: {sentence}", style="yellow")
    bad = [row.quantity for row in rows if not row.ok]
    if bad:
        for finding in (replay_json.get("diagnosis") or {}).get("findings", []):
            tell(finding["sentence"])
        raise PywetError(
            f"the replay disagrees on {', '.join(bad)}; its worst records are in replay.json; pywet replay asks again"
        )
