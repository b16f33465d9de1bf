"""Module imported once by the server from which engine processes are forked: modules loaded, laws compiled."""

from __future__ import annotations

from pywet.cases.small import small
from pywet.engines.liggghts import plugin_api, worker
from pywet.laws import registry
from pywet.laws.kinds import KINDS

READY = [worker.__name__]
_laws = {kind: registry.get(kind, name) for kind, name in small.PAPER.laws.items() if KINDS[kind].parts}
READY += [f"loop {loop.address}" for _, loop, _ in plugin_api.loops(_laws)]
for _kind in plugin_api.SLOTS.keys() & _laws:
    READY += [f"{_kind} {function.address}" for function in _laws[_kind].functions]
