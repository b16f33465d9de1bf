"""The documentation as a site: `make docs` writes docs/_build/html, without a network. Notebooks are executed as it is built."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from pygments.lexers.special import TextLexer

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent))

import pywet  # noqa: E402
from pywet.cli.reference_pages import write  # noqa: E402

project = "pywet"
release = version = pywet.__version__
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.viewcode"]
html_theme = "furo"
html_title = "pywet"
html_show_copyright = False
html_static_path = ["static"]
html_css_files = ["tables.css"]
exclude_patterns = ["_build", "README.md"]
myst_enable_extensions = ["dollarmath", "attrs_inline"]
myst_heading_anchors = 4
nb_execution_mode = "cache"
nb_execution_raise_on_error = True
nb_execution_timeout = 300
autodoc_member_order = "bysource"
autodoc_typehints = "description"


def setup(app: Any) -> None:
    """Drawings in mermaid are shown as their text (drawing them would ask the network for a program), rows of CSV too."""
    for name in ("mermaid", "csv"):
        app.add_lexer(name, TextLexer)


write(HERE)
