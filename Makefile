# Attune's commands. Each makes .venv and installs what it needs first; the second time there is nothing to do.

VENV := .venv
BIN := $(VENV)/bin
INSTALLED := $(VENV)/.installed
DEVELOPER := $(VENV)/.installed-developer
PYTHON ?= python3

# One thread for each numerical library: the control loop and the recogniser share few cores.
export OMP_NUM_THREADS := 1

# What espeak-ng synthesises depends a little on where its memory lies; at fixed addresses the tests hear the same each time.
STEADY := $(shell setarch -R true 2>/dev/null && echo setarch -R)

.PHONY: help setup demo live test test-all check bench format

help:  ## Show this list.
	@sed -n 's/^\([a-z-]*\):.*## /\1\t/p' $(MAKEFILE_LIST) | expand -t 12

setup: $(INSTALLED)  ## Make .venv and install Attune into it.

$(INSTALLED): pyproject.toml constraints.txt scripts/setup.sh
	@PYTHON="$(PYTHON)" scripts/setup.sh $(VENV) .
	@touch $@

$(DEVELOPER): $(INSTALLED)
	@PYTHON="$(PYTHON)" scripts/setup.sh $(VENV) '.[dev]'
	@touch $@

demo: $(INSTALLED)  ## The paper's two scenarios, spoken, in a simulated kitchen.
	@$(BIN)/attune demo --fast

live: $(INSTALLED)  ## Talk to the robot yourself.
	@$(BIN)/attune live

test: $(DEVELOPER)  ## All tests but the slow ones.
	@$(STEADY) $(BIN)/pytest -m "not slow" -q

test-all: $(DEVELOPER)  ## All tests.
	@$(STEADY) $(BIN)/pytest -q

check: $(DEVELOPER)  ## Lint, types and layers.
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check .
	@$(BIN)/mypy
	@$(BIN)/lint-imports

format: $(DEVELOPER)  ## Rewrite the code in the project's format.
	@$(BIN)/ruff check --fix .
	@$(BIN)/ruff format .

bench: $(DEVELOPER)  ## Measure speed; see benchmarks/README.md.
	@$(BIN)/python -m benchmarks
