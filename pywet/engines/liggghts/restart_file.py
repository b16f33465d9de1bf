"""Check that the engine's restart file is complete, which the engine itself does not check."""

from __future__ import annotations

import numpy as np


def holds(data: bytes, spheres: int) -> bool:
    """Return whether a restart file ends with complete records of this many spheres; the engine does not notice a truncated file.

    It ends with a block for each rank: the number of doubles (int32), then one record for each sphere, its
    length first. The blocks are found from the end of the file.
    """
    end = len(data)
    while spheres > 0:
        for at in _block_starts(data, end):
            numbers = np.frombuffer(data, "<f8", count=(end - at - 4) // 8, offset=at + 4)
            place = count = 0
            while place < len(numbers) and 1.0 <= numbers[place] <= len(numbers):
                place, count = place + int(numbers[place]), count + 1
            if place == len(numbers):
                break
        else:
            return False
        end, spheres = at, spheres - count
    return spheres == 0


def _block_starts(data: bytes, end: int) -> list[int]:
    """Return the positions of int32 values that equal the number of doubles up to `end`; blocks without spheres are last."""
    starts = []
    for shift in range(min(4, end - 3)):
        sizes = np.frombuffer(data, "<i4", count=(end - shift) // 4, offset=shift).astype(np.int64)
        at = shift + 4 * np.arange(len(sizes))
        starts += at[(sizes >= 0) & (8 * sizes == end - 4 - at)].tolist()
    return sorted(starts)
