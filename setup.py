"""Puts what lies alongside the package in a checkout into a wheel's package; see pywet/shipped.py. All else: pyproject.toml."""

import shutil
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

SHIPPED = ("config", "liggghts_inputs", "workflow", "Snakefile", "benchmarks/wet", "examples", "docs")
PAGES = (".md", ".ipynb")
"""What of the documentation is shipped: its pictures are ten times as large."""


class WithShipped(build_py):
    """Copies SHIPPED to pywet/shipped; an editable installation finds them where they are."""

    def run(self) -> None:
        super().run()
        if self.editable_mode:
            return
        root, target = Path(__file__).parent, Path(self.build_lib) / "pywet" / "shipped"
        shutil.rmtree(target, ignore_errors=True)
        for name in SHIPPED:
            for path in sorted([root / name, *(root / name).rglob("*")]):
                if path.is_file() and "__pycache__" not in path.parts and (name != "docs" or path.suffix in PAGES):
                    copy = target / path.relative_to(root)
                    copy.parent.mkdir(parents=True, exist_ok=True)
                    shutil.copyfile(path, copy)


setup(cmdclass={"build_py": WithShipped})
