# `make knit`, `make test` and `make docs` set themselves up; nothing else is needed than Python 3.11 and make.

PYTHON ?= python3
VENV := .venv
RUN := $(VENV)/bin/python
# linear algebra kernels of OpenBLAS for `make test-kernels`, other ones than those with which `make test` runs: with AVX2 on
# a processor that has AVX-512, and without AVX elsewhere
KERNELS ?= $(if $(shell grep -m 1 avx512f /proc/cpuinfo 2>/dev/null),Haswell,Prescott)
export WARP_CACHE_PATH ?= $(CURDIR)/.cache/warp
# the tests start many interpreters, and each of them would compile all that it imports
unexport PYTHONDONTWRITEBYTECODE

.PHONY: knit test pytest test-kernels test-gpu test-nightly lint docs setup lock clean

knit: setup
	$(RUN) -m stitchmesh knit assets/meshes/sweater.obj --stitch-width 1.5 --quality draft --device cpu -o out/sweater

# the types are checked beside the tests: they take one core for a minute
test: setup
	@$(MAKE) --no-print-directory -j 2 lint pytest

pytest: setup
	$(RUN) -m pytest -n auto --dist worksteal

# what tests decide must not follow from rounding, which differs from kernel to kernel; only the files that hold such tests
# are collected, because the imports of the others take longer than many a test
test-kernels: setup
	@for kernel in $(KERNELS); do \
		echo "tests that decide something discrete, with the linear algebra kernels of $$kernel"; \
		OPENBLAS_CORETYPE=$$kernel $(RUN) -m pytest -m 'decides and not nightly' -n auto --dist worksteal \
			$$(grep -rl --include='test_*.py' 'pytest\.mark\.decides' tests) || exit 1; \
	done

# what only a CUDA device shows: replayed graphs, and the kernels that only a GPU has
test-gpu: setup
	$(RUN) -m pytest -m gpu

# what takes minutes: the fuzzers of all readers (20 minutes on two cores, with another seed each day), every command in a
# folder of traps and with hostile words, and the long cases of tests of which `make test` runs the telling ones
SEED ?= $(shell date +%Y%m%d)
test-nightly: setup
	STITCHMESH_SEED=$(SEED) $(RUN) -m pytest -m nightly -n 2 --dist worksteal

lint: setup
	$(RUN) -m ruff check .
	$(RUN) -m mypy

# the site, out/site/index.html; a broken link is an error. The theme announces MkDocs 2 in each build, so it is silenced
docs: setup
	NO_MKDOCS_2_WARNING=1 $(RUN) -m mkdocs build --strict --quiet
	@echo out/site/index.html

setup: $(VENV)/ready

# the machine's own pip installs only the pip of the lock file, and its setuptools is not used: all that runs has a hash there
$(VENV)/ready: requirements.lock pyproject.toml
	$(PYTHON) -m venv $(VENV)
	sed -n '/^pip==/,/[^\\]$$/p' requirements.lock > $(VENV)/pip.lock
	$(RUN) -m pip install --quiet --require-hashes --only-binary :all: -r $(VENV)/pip.lock
	$(RUN) -m pip uninstall --quiet --yes setuptools
	$(RUN) -m pip install --quiet --require-hashes --only-binary :all: -r requirements.lock
	$(RUN) -m pip install --quiet --no-deps --no-build-isolation --editable .
	touch $@

# after a change of the dependencies; needs uv
lock:
	uv pip compile pyproject.toml --extra dev --extra docs --generate-hashes --no-header --python-version 3.11 -o requirements.lock

clean:
	rm -rf $(VENV) .cache out
