# Everything a new user and CI run. It needs make, gcc and Python 3.11 or newer with venv; the rest goes into .venv.

PYTHON ?= python3
BIN := .venv/bin
SOURCES := kernels server client tests

.DEFAULT_GOAL := help
.PHONY: help demo test check test-slow chaos calibrate mutants studies load bench peers image-test clean packages

help:
	@echo 'make demo        render the example scenes with the real service, then keep serving the gallery (ONCE=1: then end;'
	@echo '                 DATA=folder: also the examples whose files lie in that folder)'
	@echo 'make test        format, lint, types and the fast tests'
	@echo 'make check       format, lint and types alone'
	@echo 'make test-slow   statistical and long tests'
	@echo 'make chaos       every fault that the service survives, at every stage of a job, as a table (FAULT=words: some of it)'
	@echo 'make calibrate   statistical tests with fresh seeds: are their p-values uniform? (SEED=text: those of an earlier run)'
	@echo 'make mutants     deliberate bugs, one at a time: do the tests notice? (half an hour; SINS="word ...": some of them)'
	@echo 'make studies     the pages of kernels/studies and their figures, written anew (DATA=folder: of larger scenes too)'
	@echo 'make load        many clients at once: how quickly the service answers, what memory it takes (nothing else should run)'
	@echo 'make bench       timings, and efficiency against the other renderers that are installed (benchmarks/)'
	@echo 'make peers       Mitsuba 3, Blender Cycles and LuxCore for make bench, in .venv-peers (Cycles needs PYTHON=python3.11)'
	@echo 'make image-test  the container image, built without Docker and run; needs root and 5 GB (docker/)'
	@echo 'make clean       remove what the others made, the pictures in demo/ too'

demo: .venv/installed
	@$(BIN)/python -m woodcock_client.demo $(if $(ONCE),--once) $(if $(DATA),--data '$(DATA)')

# Two at a time: half of the time is a compiler's, which takes one core. In the order of their folders: those of few
# tests, which would come last otherwise, are browsers' and take long.
test: check | packages
	$(BIN)/python -m pytest -n 2 --dist loadfile --no-loadscope-reorder

check: .venv/installed-test
	$(BIN)/ruff format --check --quiet $(SOURCES)
	$(BIN)/ruff check --quiet $(SOURCES)
	$(BIN)/mypy

test-slow: .venv/installed-test | packages
	$(BIN)/python -m pytest -m slow

# Two at a time: much of the time something is waited for.
chaos: .venv/installed-test
	$(BIN)/python -m pytest -m 'chaos or not chaos' -q -n 2 --dist loadgroup tests/chaos $(if $(FAULT),-k '$(FAULT)')

calibrate: .venv/installed-test
	$(BIN)/python -m pytest -p tests.calibration -q -rfE $(if $(SEED),--run-seed '$(SEED)') tests/analytic tests/kernels

mutants: .venv/installed-test
	$(BIN)/python -m tests.mutants $(SINS)

studies: .venv/installed-test
	$(BIN)/python -m studies.stiff_ode
	$(BIN)/python -m studies.error_against_time
	$(BIN)/python -m studies.estimators $(if $(DATA),--data '$(DATA)')

load: .venv/installed-test
	$(BIN)/python -m pytest -m load -s tests/load

bench: .venv/installed-test
	$(BIN)/python -m pytest -m benchmark -s

# Each on its own: one that has no wheel for this Python does not stop the others.
peers:
	@test -x .venv-peers/bin/python || $(PYTHON) -m venv .venv-peers
	@for peer in mitsuba bpy==5.0.1 pyluxcore; do \
	    .venv-peers/bin/pip install --quiet --disable-pip-version-check $$peer || \
	        echo "$$peer cannot be installed here and will be skipped"; \
	done

# Without these nothing can be said of the image.
image-test: .venv/installed-test
	bash .ci/packages buildah debootstrap debian-archive-keyring iproute2 util-linux
	$(BIN)/python -m pytest -m 'image or not image' -s tests/docker

clean:
	rm -rf .venv .venv-peers benchmarks build dist demo screenshots .mypy_cache .pytest_cache .ruff_cache
	find $(SOURCES) -name __pycache__ -prune -exec rm -rf {} +

# An editable installation; again whenever pyproject.toml changes.
.venv/installed: pyproject.toml
	@command -v $(PYTHON) >/dev/null || \
	    { echo 'Python is missing: apt install python3 python3-venv (or name another with make PYTHON=...)' >&2; exit 1; }
	@$(PYTHON) -c 'import sys; v = "{}.{}".format(*sys.version_info); sys.version_info >= (3, 11) or sys.exit( \
	    "Woodcock needs Python 3.11 or newer and $(PYTHON) is " + v + ": apt install python3.11-venv, then make PYTHON=python3.11")'
	@$(PYTHON) -c 'import ensurepip, venv' 2>/dev/null || \
	    { echo 'Python cannot make virtual environments here: apt install python3-venv' >&2; exit 1; }
	@echo 'Installing into .venv (once; a minute or two)'
	@$(PYTHON) -m venv .venv
	@$(BIN)/pip install --quiet --disable-pip-version-check --editable '.[server,pocl]'
	@touch $@

.venv/installed-test: .venv/installed
	@$(BIN)/pip install --quiet --disable-pip-version-check --editable '.[test]'
	@touch $@

# Some tests use a browser, Dieharder and OpenVDB itself. Where they cannot be installed, those tests are skipped and say so.
packages:
	@bash .ci/packages chromium dieharder python3-openvdb python3-numpy || true
