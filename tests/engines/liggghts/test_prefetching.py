"""Prefetching is in the compiled plugin: a compiler drops calls that only prefetch unless they are inlined."""

from __future__ import annotations

import re
import subprocess

from pywet.engines.liggghts import build


def test_all_prefetches_of_the_loop_over_bridges_are_compiled() -> None:
    """As many instructions in `Forces::gather` as its source and that of the functions it inlines name; without one, 7 fewer."""
    source = (build.SOURCES / "forces.cpp").read_text()
    wanted = source.count("__builtin_prefetch(")
    command = ["objdump", "--disassemble=_ZN5pywet6Forces6gatherERNS_11BridgeBatchE", build.plugin_path()]
    code = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert wanted >= 9 and len(re.findall(r"\tprefetch", code)) >= wanted
