"""The engine's worker, whose plugin is given damaged checkpoints before the sound one: `python -m … RUN_DIR FOLDER STEP RANKS`.

PYWET_DAMAGED says how many; `damaged.json` in the engine's folder says how many were refused, in which words, or taken up.
"""

from __future__ import annotations

import json
import os
import random
import sys
import zlib
from collections import Counter
from pathlib import Path

from pywet.engines.liggghts import plugin_api, state_file, worker
from pywet.errors import PywetError
from tests.reliability.mangled import mangled

SOUND = plugin_api.Plugin.resume


def damaged(whole: bytes, seed: int) -> bytes:
    """Two of three with a check sum that fits, half of these with another integer somewhere, such as a count or an id."""
    rng = random.Random(seed)
    if seed % 3 == 0:
        return mangled(whole, seed)
    data = whole[:-4]
    if seed % 3 == 1:
        data = mangled(data, seed)
    else:
        at = 8 * rng.randrange(len(data) // 8)
        word = rng.choice((0, 1, 7, -1, 10**6, 2**31, 2**40, 2**62, -(2**63))).to_bytes(8, "little", signed=True)
        data = data[:at] + word + data[at + 8 :]
    return data + zlib.crc32(data).to_bytes(4, "little")


def resume(plugin: plugin_api.Plugin, state: Path) -> None:
    """Take up damaged ones in turn, once, then the sound one."""
    whole, other, ends = state.read_bytes(), Path("damaged.state"), Counter[str]()
    for seed in range(0 if Path("damaged.json").exists() else int(os.environ["PYWET_DAMAGED"])):
        other.write_bytes(damaged(whole, seed))
        Path("damaged.seed").write_text(str(seed))  # to reproduce a crash of this process
        try:
            state_file.places(other), state_file.retired(other)
            SOUND(plugin, other)
            ends["taken up"] += 1
        except PywetError as error:
            ends[str(error).replace(str(other), "FILE").partition(" says that")[0]] += 1
    if ends:
        Path("damaged.json").write_text(json.dumps(ends))
    SOUND(plugin, state)


if __name__ == "__main__":
    plugin_api.Plugin.resume = resume  # type: ignore[method-assign]
    sys.exit(worker.main())
