"""Module imported once by the server from which engine processes are forked: modules loaded, laws compiled."""

from __future__ import annotations

from pywet.cases.small import small
from pywet.engines.liggghts import plugin_api, worker
from pywet.laws import registry

READY = [worker.__name__]
for _kind in plugin_api.SLOTS.keys() & small.PAPER.laws:
    for _function in plugin_api.in_use(registry.get(_kind, small.PAPER.laws[_kind])):
        READY.append(f"{_kind} {_function.address}")
