# Everything runs in .venv, which is made on first use; python3 (>= 3.11) with venv is all it needs.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin

.PHONY: paper test test-slow test-oldest test-robots test-docs test-sensitivity fuzz soak mutation check api dist audit format benchmark gallery \
  clean

paper: $(VENV)/installed   ## simulate the paper's experiment into runs/paper/
	@echo "Simulating 80 s of the paper's arm; the first run on a machine compiles the law, ten seconds"
	$(BIN)/resonance-mj run paper

test: $(VENV)/installed-dev   ## run the tests
	$(BIN)/python -m pytest

test-slow: $(VENV)/installed-dev   ## the same from more sides: killed processes, clusters, empty caches; five minutes
	$(BIN)/python -m pytest -m slow

test-oldest:   ## the tests with the oldest versions that pyproject.toml allows, in .venv-oldest
	$(PYTHON) -m venv .venv-oldest
	.venv-oldest/bin/python -m pip install --quiet --disable-pip-version-check uv
	.venv-oldest/bin/uv pip install --quiet --python .venv-oldest --resolution lowest-direct --editable ".[dev]"
	.venv-oldest/bin/python -m pytest -W default

test-robots: $(VENV)/installed-dev   ## public arms, downloaded once (1.2 GB), and the tables of docs/robots.md
	$(BIN)/python -m pytest -m robots --dist load

test-docs: $(VENV)/installed-dev   ## every command that README and docs/ show; a quarter of an hour
	$(BIN)/python -m pytest -m docs -n 2 --dist load

test-sensitivity: $(VENV)/installed-dev   ## that the runs' expectations catch each single change
	$(BIN)/python -m pytest -m sensitivity

fuzz: $(VENV)/installed-dev   ## 10 000 mutated copies of every file that is shipped; half an hour
	$(BIN)/python benchmarks/fuzz.py --cases 10000

soak: $(VENV)/installed-dev   ## 100 000 cycles: memory, time of a cycle and torque² stay what they are; ten minutes
	$(BIN)/python benchmarks/soak.py

mutation: $(VENV)/installed-dev   ## mutation testing of the mathematics; ten minutes
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".[dev,mutation]"
	$(BIN)/python benchmarks/mutation.py

check: $(VENV)/installed-dev   ## format, lint, types, import order
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports

api: $(VENV)/installed-dev   ## API pages from the docstrings, in docs/api/
	$(BIN)/python docs/api.py

dist: $(VENV)/installed-dev   ## source archive, wheel and their digests, in dist/
	rm -rf dist
	$(BIN)/python -m hatchling build
	cd dist && sha256sum *.whl *.tar.gz > SHA256SUMS && cat SHA256SUMS

audit: $(VENV)/installed-dev   ## known holes of what is installed; asks the public advisory database
	$(BIN)/python -m pip install --quiet --disable-pip-version-check pip-audit
	$(BIN)/python -m pip_audit --skip-editable

format: $(VENV)/installed-dev
	$(BIN)/ruff format .
	$(BIN)/ruff check --fix .

benchmark: $(VENV)/installed-dev   ## the compiled law beside a bare step and a NumPy loop
	$(BIN)/python benchmarks/closed_loop.py

gallery: $(VENV)/installed   ## film the README's looping picture again
	$(BIN)/resonance-mj run seven-joint
	$(BIN)/resonance-mj render runs/seven-joint -o docs/motion.webp --from 1c --to 8c --speed 2 --fps 15 --size 880x495

clean:
	rm -rf build dist docs/api $(VENV) .venv-oldest .pytest_cache .ruff_cache .mypy_cache .import_linter_cache .hypothesis

$(VENV)/bin/python:
	$(PYTHON) -m venv $(VENV)

$(VENV)/installed: $(VENV)/bin/python pyproject.toml
	@echo "Installing resonance-mj and what it needs into $(VENV): 1 GB, a minute or two without a cache"
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable .
	@touch $@

$(VENV)/installed-dev: $(VENV)/bin/python pyproject.toml
	@echo "Installing resonance-mj, what it needs and what tests it into $(VENV): 1.2 GB, two or three minutes"
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable ".[dev]"
	@touch $@ $(VENV)/installed
