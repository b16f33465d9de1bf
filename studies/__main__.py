"""`python -m studies NAME`: what `pywet study NAME` does."""

from pywet.errors import border
from studies.command import app

with border():
    app()
