# Everything calrig needs beyond python3 (3.11 or newer), pip and make is set up by the first target that is asked for.
PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
STAMP  := $(VENV)/.set-up

export PYTHONDONTWRITEBYTECODE :=
# As many workers as processors need no threads of the linear algebra beside them.
test test-elsewhere thorough soak: export OPENBLAS_NUM_THREADS ?= 1

.PHONY: demo test test-elsewhere types-elsewhere thorough lint check bench house site links release soak clean lock setup

demo: $(STAMP)          ## the whole job on the twin, into ./demo-out
	$(BIN)/calrig demo

test: $(STAMP)          ## every test that belongs to a change
	$(BIN)/python -m pytest -q -n auto --maxprocesses 4 --dist worksteal

test-elsewhere: $(STAMP) ## the same five times: other folders, users, languages, terminals, a busy machine
	tests/circumstances.sh

lint: $(STAMP)          ## style, types, import contracts
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-logo

types-elsewhere: $(STAMP) ## types as Windows and macOS have them
	$(BIN)/mypy --platform win32 --cache-dir .mypy_cache/win32
	$(BIN)/mypy --platform darwin --cache-dir .mypy_cache/darwin

thorough: $(STAMP)      ## what `make test` leaves out: every key of both files, every benchmark, more kills and campaigns
	$(BIN)/python -m pytest -q -m "thorough and not soak" --timeout 1200 -n auto --maxprocesses 4 --dist worksteal

check: lint types-elsewhere test thorough ## all that a change must pass

bench: $(STAMP)         ## speed and memory, side by side with what a user would otherwise pick
	$(BIN)/python -m bench

house: $(STAMP)         ## draw docs/architecture.md anew from the import contracts, and docs/calrig.1 from the commands
	$(BIN)/python docs/house.py
	$(BIN)/python docs/man_page.py

site: $(STAMP)          ## the documentation as pages with search, into ./site; a warning fails
	$(BIN)/python -m sphinx -b html -q -W --keep-going docs site

links: $(STAMP)         ## whether every link of the pages leads somewhere; needs the network
	$(BIN)/python -m sphinx -b linkcheck -q docs site/links

release: site           ## what a release is made of, into ./dist: source, wheel, and the pages to read without a network
	rm -rf dist
	$(BIN)/python -m uv build --quiet --sdist --wheel --out-dir dist
	cd site && ../$(BIN)/python -m zipfile -c ../dist/calrig-pages.zip *

soak: $(STAMP)          ## the long proofs
	$(BIN)/python -m pytest -q -m soak -n 2 --timeout 7200

setup: $(STAMP)

# uv installs in seconds with every hash checked and every module compiled; plain pip serves where uv is not to be had.
$(STAMP): requirements.lock pyproject.toml
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "calrig needs Python 3.11 or newer")'
	$(PYTHON) -m venv $(VENV)
	if $(BIN)/python -m pip install --quiet 'uv>=0.7' && \
	   $(BIN)/uv pip install --quiet --python $(BIN)/python --require-hashes --compile-bytecode -r requirements.lock; then \
	  $(BIN)/uv pip install --quiet --python $(BIN)/python --no-deps --editable .; \
	else \
	  $(BIN)/python -m pip install --quiet --require-hashes -r requirements.lock && \
	  $(BIN)/python -m pip install --quiet --no-deps --editable .; \
	fi
	touch $@

lock: $(STAMP)          ## renew requirements.lock from pyproject.toml
	$(BIN)/uv pip compile --quiet --universal --python-version 3.11 --generate-hashes --no-emit-index-url --no-header \
	  --extra all --group dev pyproject.toml -o requirements.lock

clean:
	rm -rf $(VENV) demo-out build dist site docs/reference .mypy_cache .ruff_cache .pytest_cache .hypothesis .import_linter_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
