"""Run `python -m studies NAME`, like `pywet study NAME`."""

from pywet.errors import border
from studies.command import app

with border():
    app()
