"""The laws as a library: they need numpy and numba, and nothing else that is installed."""

from __future__ import annotations

import subprocess
import sys

from pywet.law_names import Laws
from pywet.laws.kinds import KINDS

ALONE = """
import sys
from importlib.abc import MetaPathFinder

ALLOWED = {*sys.stdlib_module_names, "pywet", "numpy", "numba", "llvmlite"}


class Blocked(MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] not in ALLOWED:
            raise ImportError(f"{name} is not installed")


sys.meta_path.insert(0, Blocked())
import pywet.laws

print(f"{pywet.laws.capillary.rabinovich(0.0, 0.0, 1e-3, 1e-3, 0.0, 0.0, 0.07):.6e}")
print(f"{pywet.laws.rupture.lian(1e-12, 1e-3, 1e-3, 0.2, 0.2):.6e}", *pywet.laws.registry.names("rupture"))
"""


def test_laws_need_numpy_and_numba_alone() -> None:
    """By hand: 2 pi sigma r_red 2 = 4.398230e-04 N at touch without liquid, (1 + 0.1) V^(1/3); all other imports are blocked."""
    done = subprocess.run([sys.executable, "-c", ALONE], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    force, rupture = done.stdout.splitlines()
    assert force == "4.398230e-04"
    assert rupture.split()[0] == "1.100000e-04" and "willett_unequal" in rupture


def test_every_kind_of_law_can_be_named() -> None:
    assert tuple(Laws.model_fields) == tuple(KINDS)
