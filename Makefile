# make demo    a real study, computed and drawn        make fig14 | fig15 | fig16 | studies    the paper's sweeps
# make paper_figures   signals, spectra and forces of the paper: Figs. 7, 8, 10-13, 19-21, docs/paper.md
# make figures   the figures of README and docs anew (ARGS=--list: what makes each)
# make test    all tests (test-quick: not the long)     make excitations | inner_race | roller_defect | slip | damping
# make check   tests, lint, types, imports, docs       make length | offset | tilt | misalignment | shapes
# make study STUDY=my.yaml   a study of your own: checked, run and drawn in results/my  (QUICK=1: its reduced grid)
# make stability   where each method fails             make ring_bends | ring_trends | paper_literal   (QUICK=1: fewer)
# make bench       how fast, beside peers                make bench-compare   whether speed was lost
# make speed-accuracy   which model and method to take: charts, docs/speed-accuracy.md  (QUICK=1: a small one)
# make sensitivity   what decides the line of Fig. 16: Sobol' indices, docs/sensitivity.md  (QUICK=1: fewer blocks)
PYTHON ?= python3
VENV ?= .venv
JOBS ?= 2
BIN := $(VENV)/bin
LOCK = $(BIN)/uv pip compile --quiet --python-version 3.11 --generate-hashes --no-header --no-emit-index-url --no-annotate
PYTHONS := 3.11 3.12 3.13
PYTEST = $(BIN)/python -m pytest --numprocesses auto --max-worker-restart 0 --dist loadfile --no-loadscope-reorder
FIND_PYTHON = PATH="$$PATH$$(printf ':%s' "$${PYENV_ROOT:-$$HOME/.pyenv}"/versions/*/bin)" $(BIN)/uv python find --system --no-python-downloads 2>/dev/null
SMOKE := tests/cli/test_smoke.py tests/store
CAMPAIGNS := promise random-scenes step-error choice price step-cost until many cluster repetition job-cost
FIGURES := fig14 fig15 fig16
STUDIES := $(FIGURES) damping excitations inner_race roller_defect slip length offset tilt misalignment shapes ring_bends ring_trends paper_literal models
REDUCED := $(if $(QUICK),--quick)
RESULTS = results/$@$(if $(QUICK),-quick)

# modules are compiled to bytecode once, not by each of the processes that tests start, whatever the environment says
export PYTHONDONTWRITEBYTECODE :=

.DEFAULT_GOAL := help
.PHONY: help install install-dev editor wheel-check demo figures paper_figures test test-quick test-versions smoke-lowest check lint studies study $(STUDIES) sensitivity stability docs docs-reference docs-words gallery lock clean bench bench-compare bench-peers speed-accuracy faults handshakes hostile one-folder cpu-bounds bands start start-up largest-force flags nodes diagnosis friction early-ends compiler-gains house mutants report-assets report-check $(CAMPAIGNS)

help:
	@sed -n '1,10s/^# //p' Makefile

install: $(VENV)/installed
install-dev: $(VENV)/installed-dev

$(BIN)/python:
	$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Python 3.11 or newer is needed")'
	$(PYTHON) -m venv $(VENV)

$(VENV)/installed: requirements.lock pyproject.toml | $(BIN)/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements.lock
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation -e .
	@touch $@

$(VENV)/installed-dev: requirements-dev.lock $(VENV)/installed
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r requirements-dev.lock
	@touch $@

demo: install
	$(BIN)/bearingsim run studies/fig16_angle.yaml --quick --jobs $(JOBS) --set 'record=[ring.velocity]' --out results/demo
	$(BIN)/bearingsim plot results/demo
	for kind in series envelope; do $(BIN)/bearingsim plot results/demo --kind $$kind --job all --where 'clearance=0 um' \
	  --where 'defect.width=0.8 mm' --where defect.shape=rectangular --where 'defect.angle=0 deg' || exit 1; done
	@echo "The figures are in results/demo/figures."

$(STUDIES): install
	$(BIN)/bearingsim run $(wildcard studies/$@.yaml studies/$@_*.yaml) --jobs $(JOBS) $(REDUCED) --out $(RESULTS)
	$(BIN)/bearingsim plot $(RESULTS)
	$(MORE)

excitations: MORE = $(BIN)/bearingsim plot $(RESULTS) --kind series --job all --span '10 ms' && \
  $(BIN)/bearingsim plot $(RESULTS) --kind spectrum --job all
inner_race roller_defect: MORE = for kind in spectrum envelope; do $(BIN)/bearingsim plot $(RESULTS) --kind $$kind \
  --where model=rollers --where clearance='10 um' || exit 1; done
tilt: MORE = for kind in pit load; do $(BIN)/bearingsim plot $(RESULTS) --kind $$kind --job all || exit 1; done && \
  $(BIN)/bearingsim plot $(RESULTS) --kind roller --job all --y roller.1.tilt --y roller.2.tilt \
  --y roller.1.skew --y roller.2.skew
misalignment: MORE = $(BIN)/bearingsim plot $(RESULTS) --kind load --job all

# Figs. 7, 8, 10-13 and 19-21 of the paper; docs/paper.md shows the copies in docs/figures/paper
paper_figures: install
	@for file in studies/paper/*.yaml; do name=$$(basename $$file .yaml); folder=results/paper/$$name; \
	  $(BIN)/bearingsim run $$file --jobs $(JOBS) --out $$folder && $(BIN)/bearingsim plot $$folder || exit 1; done

# a study with failed jobs is drawn, too (`sensitivity` drops their blocks); make then ends with the exit code of the run
study: OUT = results/$(basename $(notdir $(STUDY)))$(if $(QUICK),-quick)
study: install
	@test -f "$(STUDY)" || { echo "name a study file: make study STUDY=my.yaml"; exit 2; }
	$(BIN)/bearingsim check "$(STUDY)" $(REDUCED) --jobs $(JOBS)
	$(BIN)/bearingsim run "$(STUDY)" --jobs $(JOBS) $(REDUCED) --out "$(OUT)"; code=$$?; \
	  if [ $$code -le 1 ]; then $(BIN)/bearingsim plot "$(OUT)" || exit $$?; fi; exit $$code

# the figures of README and docs; NAME=tilt.png: one, ARGS=--list: what makes each, ARGS=--long: also what takes minutes
figures: install-dev
	$(BIN)/python -m benchmarks.figures $(NAME) $(ARGS)

sensitivity: install
	$(BIN)/bearingsim run studies/sensitivity.yaml --jobs $(JOBS) $(REDUCED) --out $(RESULTS); code=$$?; \
	  if [ $$code -le 1 ]; then \
	    $(BIN)/bearingsim sensitivity $(RESULTS) --of velocity@BPFO --of velocity@BPFO-healthy || exit $$?; \
	    $(BIN)/bearingsim plot $(RESULTS) || exit $$?; \
	  fi; exit $$code

stability: install
	$(BIN)/bearingsim stability $(REDUCED) --jobs $(JOBS)

studies: $(FIGURES)

# sessions, because a process keeps all that it compiles: a worker of a single one grows to 3.7 GB
test: install-dev
	@code=0; for part in tests/core/models "tests/core --ignore tests/core/models" tests/simulation \
	  "tests --ignore tests/core --ignore tests/simulation"; do $(PYTEST) $$part || code=$$?; done; exit $$code

test-quick: install-dev
	$(PYTEST) -m "not slow"

# the fast tests on each supported Python, in an environment of its own
test-versions: install-dev
	@for version in $(PYTHONS); do \
	  python=$$($(FIND_PYTHON) $$version) || { echo "Python $$version skipped: none on PATH or in pyenv"; continue; }; \
	  echo "Python $$version: $$python"; \
	  $(MAKE) --no-print-directory test-quick VENV=.venv-$$version PYTHON=$$python || exit 1; \
	done

# the wheel on each supported Python: new, check, run, plot, show with an empty and a read-only home.
# Writes docs/data/wheel_check.csv
wheel-check: install-dev
	@pythons=; for version in $(PYTHONS); do \
	  python=$$($(FIND_PYTHON) $$version) && pythons="$$pythons $$python" || \
	    echo "Python $$version skipped: none on PATH or in pyenv"; done; \
	  $(BIN)/python -m benchmarks.wheel_check --csv docs/data/wheel_check.csv $$pythons

# the lowest versions that pyproject.toml allows, without extras, on the lowest Python: commands and stored results.
# Deprecations that old packages report of each other are not ours
smoke-lowest: .venv-lowest/installed
	.venv-lowest/bin/python -m pytest $(SMOKE) -m "not slow" --numprocesses 2 --dist loadfile \
	  -W ignore::DeprecationWarning -W ignore::PendingDeprecationWarning

.venv-lowest/installed: requirements-lowest.lock pyproject.toml $(VENV)/installed-dev
	python=$$($(FIND_PYTHON) $(firstword $(PYTHONS))) || python=$(PYTHON); $$python -m venv --clear --without-pip .venv-lowest
	$(BIN)/uv pip install --quiet --python .venv-lowest/bin/python --require-hashes -r $<
	$(BIN)/uv pip install --quiet --python .venv-lowest/bin/python --no-deps --no-build-isolation -e .
	@touch $@

lint: install-dev
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/zensical build --strict

# the documentation site, in build/site: no warning, so no dead link; open build/site/index.html
docs: install-dev
	$(BIN)/zensical build --strict

# pages of docs/reference, the gallery, and tables of measurements, from the program and from docs/data
docs-reference: install-dev
	$(BIN)/python -m docs.scripts.reference

# docs/gallery.md: every committed figure with its study
gallery: install-dev
	$(BIN)/python -m docs.scripts.reference gallery.md

# words of reading pages by page, apart from evidence and generated pages: a report, no test
docs-words: install-dev
	@$(BIN)/python -m docs.scripts.words

check: lint test

# ONLY=peers, or other sections: docs/benchmarks.md
bench: install-dev
	$(BIN)/python -m benchmarks.speed $(ONLY) --out results/bench

# the whole chart is written into docs/, the small one beside its figures
speed-accuracy: install-dev
	$(BIN)/python -m benchmarks.speed_accuracy $(REDUCED) --jobs $(JOBS)

# is anything lost when a disk is full, a bit flips, a process ends? As root also on small disks
faults: install-dev
	$(BIN)/python -m benchmarks.faults $(ONLY)

# 40 changes of the program, drawn by seed: do tests notice? Writes docs/data/mutants.csv. Up to an hour
mutants: install-dev
	$(BIN)/python -m benchmarks.mutants --csv docs/data/mutants.csv $(ARGS)

# lint the script of the page of results and bundle ECharts for it; needs Node.js and npm
report-assets:
	cd tools/report-assets && npm ci --no-audit --no-fund --ignore-scripts && npm run lint && npm run bundle && npm run notices

# the page of results in Chromium, with axe-core: its tests skip what is not installed
report-check: install-dev
	cd tools/report-assets && npm ci --no-audit --no-fund --ignore-scripts
	$(PYTEST) tests/report

# sizes of files and functions by package, and import cycles: a report, no test
house: install-dev
	$(BIN)/python -m benchmarks.house

# is a wrong scheduler told in time, and does Ctrl-C end the run meanwhile? Writes docs/data/handshakes.csv
handshakes: install-dev
	$(BIN)/python -m benchmarks.handshakes

# broken, mistaken and hostile study files: are they refused with a place, and in time? Writes docs/data/check_limits.csv
hostile: install-dev
	$(BIN)/python -m benchmarks.hostile
	$(BIN)/python -m benchmarks.check_limits

# what does an editor mark in study files? Needs npm. Writes docs/data/editor.csv
editor: install-dev
	$(BIN)/python -m benchmarks.editor --csv docs/data/editor.csv

# does a job end by its CPU time, whichever phase takes it? Writes docs/data/cpu_bounds.csv
cpu-bounds: install-dev
	$(BIN)/python -m benchmarks.cpu_bounds --csv docs/data/cpu_bounds.csv

# three runs of an edited study in one folder: is a job lost or computed in vain? Writes docs/data/one_folder.csv
one-folder: install-dev
	$(BIN)/python -m benchmarks.one_folder

# lines of envelopes, RMS of a band at any sampling, contact forces: are they what they are called? Writes docs/data/bands.csv
bands: install-dev
	$(BIN)/python -m benchmarks.bands --csv docs/data/bands.csv

# CPU time of commands that compute nothing. Writes docs/data/start_up.csv
start-up: install-dev
	$(BIN)/python -m benchmarks.speed.start_up --csv docs/data/start_up.csv

# does a run forget its start, and is what it remembers said? Writes docs/data/start.csv
start: install-dev
	$(BIN)/python -m benchmarks.start --csv docs/data/start.csv

# does the standard error of a free cage's largest force cover its scatter? Writes docs/data/largest_force.csv
largest-force: install-dev
	$(BIN)/python -m benchmarks.largest_force --csv docs/data/largest_force.csv

# is a result flagged as one draw of many where it is not known to 0.5 %? Writes docs/data/flags.csv
flags: install-dev
	$(BIN)/python -m benchmarks.flags

# bowls and spalls at four times the nodes: within the error that is said? Writes docs/data/nodes.csv
nodes: install-dev
	$(BIN)/python -m benchmarks.nodes --csv docs/data/nodes.csv

# what does `analyze` find in which noise, and which widths does it state? Writes docs/data/diagnosis.csv, diagnosis_sizes.csv
diagnosis: install-dev
	$(BIN)/python -m benchmarks.diagnosis.operating_table
	$(BIN)/python -m benchmarks.diagnosis.sizes

# campaigns on random scenes: ARGS='--cases 20' and others, as of `python -m benchmarks.NAME --help`
$(CAMPAIGNS): install-dev
	$(BIN)/python -m benchmarks.$(subst -,_,$@) $(ARGS)

# does an accuracy hold against friction and a free cage, at which cost? Writes docs/data/friction.csv
friction: install-dev
	$(BIN)/python -m benchmarks.friction --csv docs/data/friction.csv

# do records that end early hold an accuracy, at which cost against an earlier commit? Writes docs/data/early_ends.csv
early-ends: install-dev
	$(BIN)/python -m benchmarks.early_ends --seconds inf --csv docs/data/early_ends.csv $(ARGS)

# what do linked compilation and sums in vector registers gain? Two minutes
compiler-gains: install-dev
	$(BIN)/python -m benchmarks.compiler_gains

bench-compare: install-dev
	$(BIN)/python -m benchmarks.speed.compare

bench-peers: install-dev
	$(BIN)/uv pip install --quiet --python $(BIN)/python --group peers
	-$(BIN)/uv pip install --quiet --python $(BIN)/python --group peers-from-source

lock: install-dev
	$(LOCK) --universal --group build pyproject.toml -o requirements.lock
	$(LOCK) --universal --group dev pyproject.toml -o requirements-dev.lock
	$(LOCK) --resolution lowest-direct --group build --group tests pyproject.toml -o requirements-lowest.lock

clean:
	rm -rf build dist .pytest_cache .mypy_cache .ruff_cache .import_linter_cache .hypothesis .cache
