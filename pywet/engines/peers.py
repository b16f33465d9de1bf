"""Build the plugins of YADE and LAMMPS before the first run, if these are installed; called by `make peers`."""

from __future__ import annotations

from pywet.engines.lammps import build as lammps
from pywet.engines.yade import build as yade
from pywet.errors import EngineError, border


def main() -> None:
    """Build plugins that are not in the cache; an engine that is not installed is skipped."""
    for name, engine in (("YADE", yade), ("LAMMPS", lammps)):
        try:
            engine.engine_version()
        except EngineError as error:
            print(f"no plugin for {name}: {error}", flush=True)
            continue
        print(f"plugin for {name}: {engine.plugin_path()}", flush=True)


if __name__ == "__main__":
    with border():
        main()
