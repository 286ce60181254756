# make demo   a fault found in shipped recordings of a rotor, and the truth afterwards: demo/report.html
# make test   the test suite; make test-slow  its long searches and sweeps, by hand
# Both need only Python 3.11 or newer and a package index; they make .venv themselves.
# PYTHON=/path/to/python picks another interpreter, PYTEST_ARGS passes options to pytest.

VENV := .venv
BIN := $(VENV)/bin
PYTEST_ARGS ?=
# Recipes are one shell each, so that a failing line stops them.
SHELL := /bin/bash
.SHELLFLAGS := -euo pipefail -c

# Where there is uv it installs, in a tenth of the time; where it cannot, pip does.
UV ?= $(shell command -v uv 2>/dev/null)
INSTALL = install() { \
  { [ -n "$(UV)" ] && $(UV) pip install --quiet --python "$$1" "$${@:2}" 2>/dev/null; } || \
  "$$1" -m pip install --quiet --disable-pip-version-check --no-compile "$${@:2}"; \
}; install

.PHONY: demo test test-slow test-oldest test-oldest-some lint clean
.DELETE_ON_ERROR:

demo: $(VENV)/stamp-run
	$(BIN)/rotorwise demo --output demo --force

# One BLAS thread a process: there are as many processes as cores, and the matrices are small. Compiled modules are kept,
# also where the environment says not to: each of the many processes that the tests start would compile all of them.
TEST_ENV := OPENBLAS_NUM_THREADS=1 PYTHONDONTWRITEBYTECODE=

test: $(VENV)/stamp-test
	$(TEST_ENV) $(BIN)/pytest -n auto --dist worksteal $(PYTEST_ARGS)

# Long searches and sweeps beside quicker ones of their kind, which `make test` leaves out.
test-slow: $(VENV)/stamp-test
	$(TEST_ENV) $(BIN)/pytest -n auto --dist worksteal -m slow --durations=10 $(PYTEST_ARGS)

lint: $(VENV)/stamp-lint
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/pyright --pythonpath $(BIN)/python

# With the oldest versions that pyproject.toml allows: what reads and writes files, the signal processing, the learning,
# and the simulators' solvers on every machine, but for some slow files. One BLAS thread: with several, numpy 1.26 rounds
# differently from process to process, and datasets would not be the same to the last bit.
OLDEST := tests/datasets tests/signal tests/diagnose/signal tests/severity tests/report tests/diagnose/learning \
  tests/diagnose/test_blocks_and_features.py tests/diagnose/test_faults.py tests/simulators/solvers tests/simulators/machines

# Slow ones: quicker ones beside them look at the same libraries.
NOT_OLDEST := not killed and not disk and not kept and not computes and not memory_is_a_location and not goes_on \
  and not random_combs and not slow_shaft and not confidence_is_honest and not share_of_frames \
  and not independent_solver and not implicit_solver and not unrelated_lines

test-oldest: .venv-oldest/stamp
	$(TEST_ENV) .venv-oldest/bin/pytest -n auto --dist worksteal -m "not browser and not slow" \
	  --ignore tests/simulators/solvers/test_gearbox_accuracy.py --ignore tests/datasets/test_store_lease.py \
	  --ignore tests/diagnose/signal/test_critical_speed.py -k "$(NOT_OLDEST)" $(OLDEST) $(PYTEST_ARGS)

# A part of it: reading, signals, learning and the machines once, a minute less.
OLDEST_SOME := tests/datasets/test_readers_contract.py tests/datasets/test_recipe.py tests/signal/test_spectrum.py \
  tests/signal/test_order_tracking.py tests/severity tests/diagnose/learning/test_classifier.py tests/diagnose/test_faults.py \
  tests/simulators/machines

test-oldest-some:
	$(MAKE) test-oldest OLDEST="$(OLDEST_SOME)"

.venv-oldest/stamp: tests/oldest.txt pyproject.toml | $(VENV)/stamp-venv
	rm -rf .venv-oldest
	$(BIN)/python -m venv .venv-oldest
	@$(INSTALL) .venv-oldest/bin/python -c tests/oldest.txt -e '.[test]'
	touch $@

clean:
	rm -rf $(VENV) .venv-oldest demo build *.egg-info .pytest_cache .ruff_cache .hypothesis

# A changed pyproject.toml is newer than the stamps and installs again.
$(VENV)/stamp-run: pyproject.toml | $(VENV)/stamp-venv
	@$(INSTALL) $(BIN)/python -e .
	touch $@

$(VENV)/stamp-test: pyproject.toml | $(VENV)/stamp-venv
	@$(INSTALL) $(BIN)/python -e '.[test,test-stores]'
	touch $@ $(VENV)/stamp-run

$(VENV)/stamp-lint: pyproject.toml | $(VENV)/stamp-venv
	@$(INSTALL) $(BIN)/python -e '.[test,test-stores,lint]'
	touch $@ $(VENV)/stamp-test $(VENV)/stamp-run

# A stamp, not bin/python: an environment whose making was interrupted has bin/python but no pip.
$(VENV)/stamp-venv:
	@found=; \
	for candidate in $(PYTHON) python3 python3.14 python3.13 python3.12 python3.11 python; do \
	  if command -v "$$candidate" >/dev/null 2>&1 && \
	     "$$candidate" -c 'import sys; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1; then \
	    found="$$candidate"; break; \
	  fi; \
	done; \
	if [ -z "$$found" ]; then \
	  echo "No Python 3.11 or newer found (tried python3, python3.11 to python3.14, python)." >&2; \
	  echo "Install one, or say where it is: make PYTHON=/path/to/python3.11 ..." >&2; \
	  exit 1; \
	fi; \
	echo "Setting up $(VENV) with $$("$$found" --version). The first time takes a minute or two."; \
	rm -rf $(VENV); \
	if ! "$$found" -m venv $(VENV); then \
	  rm -rf $(VENV); \
	  echo "$$found cannot make a virtual environment. On Debian and Ubuntu: apt install python3-venv" >&2; \
	  exit 1; \
	fi; \
	touch $@
