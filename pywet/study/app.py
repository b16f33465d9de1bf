"""Subcommands of `pywet study`; each imports its study when it is called."""

from __future__ import annotations

import typer

app = typer.Typer(no_args_is_help=True, help="Studies: what accuracy costs, what stays stable, which effects count.")
