# Two commands do everything on a fresh machine with Python >= 3.11:
#   make app     sets up .venv, serves the designer, prints its address (with the token that opens it)
#                and opens it where there is a display; LLSRBM_TOKEN=... make app takes a token
#   make test    sets up .venv and a browser, then runs the tests
# Others: make test-all (also the tests that are marked `nightly`: those that take longest, of
# sweeps whose processes are killed, of the documentation's site), make durations (all, and keeps how
# long each file takes, which orders later runs), make check (style and types), make bench (solve times; AGAINST=commit compares with an
# older version, BENCH_ARGS=--crocoddyl with Crocoddyl), make range (random requests over all that may
# be asked, planned and simulated), make paper (the paper's results into docs/paper.md), make peers
# (other planners on the same jumps into docs/peers.md), make docs (the documentation as a site, in
# build/site), make lock (renew the pins), make clean.

# The first that is new enough, and python3 to complain about if none is.
PYTHON ?= $(or $(shell for python in python3 python3.11 python3.12 python3.13; do \
	$$python -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && \
	echo $$python && break; done),python3)
VENV   ?= .venv
HOST   ?= 127.0.0.1
PORT   ?= 8080

# Two processes: the tests wait as much as they work. `make test PROCESSES=` takes one.
PROCESSES ?= -n 2 --dist loadscope
PYTEST    = $(BIN)/python -m pytest $(PROCESSES)

BIN    := $(VENV)/bin
PIP    := $(BIN)/python -m pip install --disable-pip-version-check --quiet

# Files that say "done", so that a second run is instant.
APP_STAMP := $(VENV)/.llsrbm-app
DEV_STAMP := $(VENV)/.llsrbm-dev

.PHONY: app test test-all durations check format bench range paper peers docs lock clean setup drawn
.DEFAULT_GOAL := app

app: $(APP_STAMP)
	exec $(BIN)/llsrbm serve --host $(HOST) --port $(PORT)

test: $(DEV_STAMP) drawn
	$(PYTEST) -m "not nightly" $(PYTEST_ARGS)

test-all: $(DEV_STAMP) drawn
	$(PYTEST) $(PYTEST_ARGS)

durations: $(DEV_STAMP) drawn
	$(PYTEST) --record-durations $(PYTEST_ARGS)

drawn: $(DEV_STAMP)
	.ci/browser $(BIN)/python
	.ci/drawing $(BIN)/python || true

check: $(DEV_STAMP)
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports

format: $(DEV_STAMP)
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

bench: $(APP_STAMP)
	$(BIN)/python -m benchmarks.solve_times $(if $(AGAINST),--against $(AGAINST)) $(BENCH_ARGS)

range: $(APP_STAMP)
	$(BIN)/python -m benchmarks.range

docs: $(DEV_STAMP)
	$(BIN)/python -m mkdocs build --strict --clean

# Both draw or compare with what only the tests' environment has.
paper: $(DEV_STAMP)
	.ci/drawing $(BIN)/python
	$(BIN)/python -m benchmarks.paper

peers: $(DEV_STAMP)
	$(BIN)/python -m benchmarks.peers

setup: $(DEV_STAMP)

$(BIN)/python:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { \
	  echo "llsrbm needs Python 3.11 or newer; say which: make PYTHON=python3.11" >&2; exit 1; }
	$(PYTHON) -m venv $(VENV)

$(APP_STAMP): requirements.lock pyproject.toml | $(BIN)/python
	@echo "installing what the application needs (once, some minutes)"
	$(PIP) -r requirements.lock
	$(PIP) --no-deps -e .
	@$(BIN)/python -c "import casadi, fast_simplification, mujoco, pinocchio, viser" || { \
	  echo "a library of the system is missing; if it is libgomp: apt-get install libgomp1" >&2; \
	  exit 1; }
	@touch $@

$(DEV_STAMP): requirements-dev.lock $(APP_STAMP)
	@echo "installing what the tests need (once)"
	$(PIP) -r requirements-dev.lock
	@touch $@

# Keeps the pins that still satisfy pyproject.toml; `make lock UPGRADE=--upgrade` takes the newest.
# The page offers every format but rerun's, whose package takes half a gigabyte.
# One file for every Python from 3.11 on; checked on x86-64 Linux.
COMPILE = build/lock/bin/uv pip compile --quiet $(UPGRADE) --universal --python-version 3.11 \
	--generate-hashes --no-emit-index-url --no-annotate --no-header
lock:
	$(PYTHON) -m venv build/lock
	build/lock/bin/python -m pip install --disable-pip-version-check --quiet uv
	$(COMPILE) pyproject.toml --extra mcap --extra video -o requirements.lock
	$(COMPILE) pyproject.toml --all-extras --group dev -c requirements.lock -o requirements-dev.lock

clean:
	rm -rf $(VENV) build dist *.egg-info .pytest_cache .ruff_cache .mypy_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
