# The two commands: `make run PHOTOS=folder [OUT=results] [ARGS="..."]` and `make test`.
PYTHON ?= python3
OUT ?= results
ARGS ?=
BIN := .venv/bin

.PHONY: run test lint setup lock docs clean

run: .venv/.ready
	@test -n "$(PHOTOS)" || { echo 'make run needs a folder: make run PHOTOS=folder [OUT=results]' >&2; exit 2; }
	$(BIN)/proxemetry models fetch
	$(BIN)/proxemetry measure "$(PHOTOS)" --out "$(OUT)" --overlays $(ARGS)

test: .venv/.ready-to-test
	$(BIN)/proxemetry models fetch
	$(BIN)/python -m pytest -n 2 $(ARGS)

lint: .venv/.ready-to-test
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/pyright

docs: .venv/.ready-to-test
	$(BIN)/python docs/build.py

setup: .venv/.ready

# Only hashed wheels of the lock file are installed; the package itself comes last, without looking anything up.
.venv/.ready: requirements.lock pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { echo 'proxemetry needs Python 3.11 or newer; set PYTHON=python3.x' >&2; exit 2; }
	test -x $(BIN)/python || $(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes --only-binary :all: -r requirements.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --editable .
	touch $@

.venv/.ready-to-test: .venv/.ready requirements-dev.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes --only-binary :all: -r requirements-dev.lock
	touch $@

# Needs `uv`; the answer is for every platform and Python from 3.11.
LOCK := uv pip compile --universal --python-version 3.11 --generate-hashes --no-header --quiet $(LOCKARGS)
lock:
	$(LOCK) --extra all pyproject.toml -o requirements.lock
	$(LOCK) --extra all --extra cluster --group test --group browser --group cluster --group docs -c requirements.lock pyproject.toml -o requirements-dev.lock

clean:
	rm -rf .venv .pytest_cache .ruff_cache .hypothesis build dist site
