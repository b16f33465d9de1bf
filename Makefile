# The two commands: `make run` and `make test`. Each sets up what it needs.
CORES ?= $(shell nproc)
SCALE ?= smoke
PYTHON := .venv/bin/python

.PHONY: help setup lint test run bench report clean

help:  ## this list
	@grep -E '^[a-z]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/'

setup:  ## engines by apt where missing, Python in .venv, the plugin
	@tools/setup

lint: setup  ## ruff and mypy
	.venv/bin/ruff check .
	.venv/bin/ruff format --check .
	.venv/bin/mypy

test: setup lint  ## lint and all tests (not those marked slow)
	$(PYTHON) -m pytest -n 2 -m "not slow"

run: setup  ## the 18 screening cases, cross-check and report
	.venv/bin/snakemake --cores $(CORES) --profile workflow/profiles/default --config scale=$(SCALE)
	@echo "The report is in results/$(SCALE)/report.html"

report: setup  ## the report alone, from what is there
	.venv/bin/snakemake --cores $(CORES) --profile workflow/profiles/default --config scale=$(SCALE) -- report

bench: setup  ## cost of a step, side by side
	$(PYTHON) benchmarks/step_cost.py

clean:  ## results and caches; keeps .venv
	rm -rf results .snakemake .pytest_cache .mypy_cache .ruff_cache
