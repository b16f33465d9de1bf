# The two commands: `make run` and `make test`. Each sets up what it needs.
CORES ?= $(shell nproc)
ENGINE ?= liggghts
PYTHON := .venv/bin/python
CHOSEN = engine=$(ENGINE)$(if $(SCALE), scale=$(SCALE))
CONFIGURED = $(shell $(PYTHON) -c "from pywet import config; print(config.load('config').settings.scale)" 2>/dev/null)
REPORT = results/$(or $(SCALE),$(CONFIGURED))$(if $(filter-out liggghts,$(ENGINE)),_$(ENGINE))/report.html

# Cores go to cases and tests, not to small matrices: threads that wait for each other on busy cores are 20 times slower.
export OPENBLAS_NUM_THREADS ?= 1

# Where the home cannot be written, caches stay in this folder.
ifneq ($(shell test -w "$$HOME" && echo yes),yes)
export XDG_CACHE_HOME ?= $(CURDIR)/.cache
export MPLCONFIGDIR ?= $(XDG_CACHE_HOME)/matplotlib
endif

LINT = .venv/bin/ruff check . && .venv/bin/ruff format --check . && .venv/bin/mypy && tools/cppcheck && $(PYTHON) tools/glossary --check

.PHONY: help essentials setup peers lint test cluster run full bench docs report clean

help:  ## this list
	@grep -E '^[a-z]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/'

essentials:  ## what simulations need: engine by apt where missing, Python in .venv, the plugin
	@tools/setup --essentials

setup:  ## the same, packages for development, and code for single collisions compiled ahead
	@tools/setup

peers:  ## YADE and LAMMPS for comparisons, chromium for pages too, where they can be installed
	@tools/setup --peers

lint: setup  ## ruff, mypy, the glossary and, where it is installed, cppcheck
	$(LINT)

# mypy has one thread: side by side with the tests it costs no time of its own
test: peers  ## lint and all tests (not those marked slow)
	@{ $(LINT); } & lint=$$!; status=0; $(PYTHON) -m pytest -n 3 -m "not slow" || status=$$?; \
	wait $$lint || { echo "make lint fails, its reason is above"; exit 1; }; exit $$status

cluster:  ## the workflow on a SLURM of this machine, as root; skipped where Debian's packages cannot be installed
	@tools/setup --slurm
	$(PYTHON) -m pytest -rs tests/cluster

run: $(if $(filter-out liggghts,$(ENGINE)),peers,essentials)  ## the 18 screening cases, cross-check and report; then a sweep of 24 small runs. ENGINE=yade: in YADE
	@$(PYTHON) -m pywet.cli.workflow_lock
	@status=0; .venv/bin/snakemake --cores $(CORES) --profile workflow/profiles/default --config $(CHOSEN) || status=$$?; \
	[ $(ENGINE) != liggghts ] || .venv/bin/pywet sweep examples/sweeps/small_drum.yaml --cores $(CORES) || status=$$?; \
	report=$(REPORT); [ ! -e $$report ] || echo "The report is in $$report"; exit $$status

report: $(if $(filter-out liggghts,$(ENGINE)),peers,essentials)  ## the report, with the cases that it still needs. ENGINE=yade: in YADE
	@$(PYTHON) -m pywet.cli.workflow_lock
	.venv/bin/snakemake --cores $(CORES) --profile workflow/profiles/default --config $(CHOSEN) -- report verdict

full: essentials  ## the page of the 18 cases at full scale, after hours of runs where their tables are not stored (all are)
	$(PYTHON) -m studies.full_scale.campaign --cores $(CORES)
	$(PYTHON) -m studies.full_scale.page

docs: setup  ## the documentation as a site, docs/_build/html; its notebooks are executed
	$(PYTHON) -m sphinx -q -W --keep-going -b html docs docs/_build/html
	@echo "The documentation is in docs/_build/html/index.html"

bench: setup  ## cost of a step, side by side; collisions per second
	$(PYTHON) benchmarks/step_cost.py
	$(PYTHON) benchmarks/collisions.py

clean:  ## results and caches; keeps .venv
	rm -rf results docs/_build .snakemake .cache .pytest_cache .mypy_cache .ruff_cache
