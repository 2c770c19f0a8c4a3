# Everything a fresh machine needs: Python ≥ 3.11 and a C++ compiler (or the extra `compiler`).
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
SPHINX := $(BIN)/python -m sphinx --quiet --keep-going --conf-dir docs/_site
CODE := model observers codegen studies hillobs tests benchmarks docs

.DEFAULT_GOAL := help
.PHONY: help sim sweep estimate test portable check format lint types imports observability lag league docs links page chaos hostile bench clean

help: ## show this help
	@grep -hE '^[a-z]+:.*##' $(MAKEFILE_LIST) | sed 's/:.*## /\t/' | expand -t 16

# installed once, and again whenever the dependencies change
$(VENV)/.installed: pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[dev]'
	@mkdir -p $(VENV)/types/hillobs && for part in hillobs/*.py hillobs/py.typed model observers codegen studies; do \
		ln -sfn "$(CURDIR)/$$part" $(VENV)/types/hillobs/; done
	@ln -sfn "$(CURDIR)/benchmarks" $(VENV)/types/
	@touch $@

sim: $(VENV)/.installed ## both of the paper's simulations, with all figures, into results/
	$(BIN)/hillobs simulate

sweep: $(VENV)/.installed ## error over ε_h, δ_s and δ_a, with and without noise, and a map, into results/
	$(BIN)/python -m hillobs.studies.cli.pages.sweep

estimate: $(VENV)/.installed ## activations from the shipped recording, scored, with a sheet, into results/estimate/
	$(BIN)/hillobs estimate studies/laboratory/recordings/dgf_smooth_noisy.csv.gz --muscles studies/laboratory/recordings/dgf_smooth.toml \
		--observer high_gain --observer high_gain_3 --observer sliding_mode --observer adaptive_sliding_mode \
		--out results/estimate

test: $(VENV)/.installed ## all tests
	$(BIN)/python -m pytest

$(VENV)/.portable: $(VENV)/.installed
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[dev,compiler]'
	@touch $@

# for ARM: apt install qemu-user g++-aarch64-linux-gnu
portable: $(VENV)/.portable ## what compiled code computes, for every processor, system and compiler that can be tried here
	$(BIN)/python tests/portable.py

check: format lint types imports test ## what CI runs: format, lint, types, the stair of imports, tests

format: $(VENV)/.installed ## is the code formatted?
	$(BIN)/ruff format --check $(CODE)

lint: $(VENV)/.installed ## ruff's rules
	$(BIN)/ruff check $(CODE)

types: $(VENV)/.installed ## mypy, strict
	cd $(VENV)/types && ../bin/mypy --config-file ../../pyproject.toml -p hillobs -p benchmarks

imports: $(VENV)/.installed ## do imports go down the stair only? (contracts in pyproject.toml)
	cd $(VENV)/types && PYTHONPATH=. ../bin/lint-imports --config ../../pyproject.toml --cache-dir ../../.import_linter_cache

observability: $(VENV)/.installed ## ranks, maps and figures of docs/observability.md
	$(BIN)/python -m hillobs.studies.cli.pages.observability

lag: $(VENV)/.installed ## figure of docs/kalman.md: errors over the delay
	$(BIN)/python -m hillobs.studies.cli.pages.lag

league: $(VENV)/.installed ## every observer in every situation, the paper's claims tried: docs/league.md
	$(BIN)/python -m hillobs.studies.cli.pages.league

$(VENV)/.docs: $(VENV)/.installed
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[dev,docs]'
	@touch $@

# a warning is an error
docs: $(VENV)/.docs page ## the site of all pages, with the reference: docs/_build/html/index.html
	$(SPHINX) --fail-on-warning --builder html docs docs/_build/html
	@echo "docs/_build/html/index.html"

links: $(VENV)/.docs ## do the pages' links to other sites lead somewhere? This one asks the internet
	$(SPHINX) --builder linkcheck docs docs/_build/links

page: $(VENV)/.installed ## the paper's noisy simulation as a page for a browser: docs/_page/paper-noisy.html
	$(BIN)/hillobs export page paper-noisy --out docs/_page/paper-noisy.html

chaos: $(VENV)/.docs page ## long tests: kills, full disks, races; and all laws, on inputs drawn anew
	$(BIN)/python -m pytest -m 'chaos or hypothesis' --hypothesis-profile others -p no:cacheprovider

# SEED=1 draws others, CASES=200 fewer, CASE=17 one of them again
hostile: $(VENV)/.installed ## 2,000 drawn commands among drawn files, surroundings and signals: no promise may break
	PYTHONPATH=tests $(BIN)/python -m hostile --seed $(or $(SEED),0) --cases $(or $(CASES),2000) $(if $(CASE),--case $(CASE))

# peers that fail to install are skipped
$(VENV)/.bench: $(VENV)/.installed
	-$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[dev,bench]'
	@touch $@

bench: $(VENV)/.bench ## how fast the loop is beside CasADi's C, numba, JAX …: docs/performance.md
	$(BIN)/python -m benchmarks

clean: ## remove results, caches and compiled libraries
	rm -rf results build/cache .setuptools .pytest_cache .mypy_cache .ruff_cache .import_linter_cache .hypothesis
