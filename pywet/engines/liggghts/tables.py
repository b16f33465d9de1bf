"""Makes ready, before a run, what its laws read: tables are solved here once, with progress, and kept in the cache."""

from __future__ import annotations

from rich.console import Console
from rich.progress import Progress

from pywet.engines.liggghts.plugin_api import SLOTS, angle_pairs
from pywet.laws import registry
from pywet.scene import Scene


def prepare_laws(scene: Scene) -> None:
    """Tables of all laws of the scene that need one."""
    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("exact bridge tables (kept for later runs)", total=None, visible=False)

        def report(done: int, of: int) -> None:
            bar.update(task, completed=done, total=of, visible=True)

        for kind in SLOTS:
            if kind in scene.effects.laws:
                registry.get(kind, scene.effects.laws[kind]).prepare(angle_pairs(scene), report)
