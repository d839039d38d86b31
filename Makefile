# The two commands of the README are `make demo` and `make test`; everything lives in .venv.
# On aarch64 the RealSense SDK has a wheel for Python 3.12 alone; elsewhere 3.11 is tested most.
PYTHONS := $(if $(filter aarch64,$(shell uname -m)),python3.12 python3.11,python3.11 python3.12) python3.13 python3.14 python3
runs = $(shell $(1) -c 'import sys; print(sys.executable)' 2>/dev/null)
ifndef PYTHON
PYTHON := $(firstword $(foreach name,$(PYTHONS),$(call runs,$(name))) python3)
endif
# What shows that there is an NVIDIA driver, and where PyTorch is without CUDA; the tests give others.
NVIDIA_PROC ?= /proc/driver/nvidia/version
NVIDIA_SMI ?= nvidia-smi
CPU_INDEX ?= https://download.pytorch.org/whl/cpu
NVIDIA = $(or $(wildcard $(NVIDIA_PROC)),$(shell $(NVIDIA_SMI) -L >/dev/null 2>&1 && echo $(NVIDIA_SMI)))
ifeq ($(origin PIP_ARGS),undefined)
WITH_CUDA := , for $(NVIDIA) shows an NVIDIA driver
ifeq ($(NVIDIA),)
WITHOUT_CUDA := , since no NVIDIA driver is here; another one with: make PIP_ARGS="--extra-index-url URL"
WITH_CUDA := , though no NVIDIA driver is here: $(CPU_INDEX) cannot be reached. Ctrl-C ends this; try again later, or give another index with: make PIP_ARGS="--extra-index-url URL"
# One try more: where that index does not answer, five for each package would take a minute.
PIP_ARGS := --retries 1 --extra-index-url $(CPU_INDEX)
endif
endif
# Tests of what people who work on the project use; TESTS names a part of either.
BENCHMARKS := tests/test_benchmarks tests/test_training tests/tools
PRODUCT := $(filter-out $(BENCHMARKS),$(wildcard tests/test_*) tests/fuzz)
TESTS ?=
BIN := .venv/bin
PAGE := vizbot/operator/page
RENDERING := libegl1 libgl1
FURNITURE := sweethome3d-furniture
# Node, the driver of the browser in the tests and what checks the page's scripts, links to it.
NODE_WITH := libatomic1
TESTED_WITH := espeak-ng $(NODE_WITH)
OPTIONAL := $(FURNITURE)
installed = dpkg-query -W -f='$${Status}' $(1) 2>/dev/null | grep -q '^install ok installed'

.PHONY: demo test test-slow test-benchmarks test-long check install develop lock sbom python system clean

demo: install
	@echo "Driving to a yellow chair in a simulated home: a minute or two"
	$(BIN)/vizbot dry-run "yellow chair" --world 1100

# pytest's 5 says that TESTS names no test of a kind. What all of them cost is printed at the end.
SPENT = .venv/spent/$@
RUN = $(BIN)/pytest -q -rs --durations=30 --spent $(SPENT)
define tested
	@rm -f $(SPENT)
	$(RUN) -n 2 --dist worksteal -m "not alone and not hardware$(1)" $(or $(TESTS),$(2)) || [ $$? -eq 5 ]
endef
# Tests that are `alone` judge times on the wall clock: they run last, with nothing beside them, and their
# files alone are read.
tested_alone = $(RUN) -m "alone and not hardware$(1)" $(or $(TESTS),$(shell grep -rl --include='test_*.py' 'mark\.alone' tests)) || [ $$? -eq 5 ]
spent = @awk '{ used += $$1; took += $$2 } END { printf "make $@: %.0f s of processor in %.0f s\n", used, took }' $(SPENT)

test: develop
	$(call tested, and not slow and not long,$(PRODUCT))
	$(spent)

test-slow: develop
	$(call tested, and slow and not long,$(PRODUCT))
	$(call tested_alone, and not long)
	$(spent)

test-benchmarks: develop
	$(call tested, and not long,$(BENCHMARKS))
	$(spent)

# Here compiled kernels check every index: one out of bounds would write over what lies beside an array.
test-long: export NUMBA_BOUNDSCHECK = 1
test-long: export NUMBA_CACHE_DIR = $(CURDIR)/.venv/checked-kernels
test-long: develop
	$(call tested,,tests)
	$(call tested_alone)
	$(spent)

check: develop .venv/page-tools
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/oxlint --config $(PAGE)/.oxlintrc.json --deny-warnings $(PAGE)/scripts
	$(BIN)/node .venv/page/node_modules/typescript/bin/tsc --project $(PAGE)/jsconfig.json

# What rehearsals need; `develop` adds what checks and tests do.
install: python system .venv/installed

develop: install .venv/developed

# What is wrong with the Python that was found, in one line, before anything is installed for it.
python:
	@$(PYTHON) -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 14))' || { \
	  echo "vizbot needs Python 3.11 to 3.14; $(PYTHON) is $$($(PYTHON) -V 2>&1). Give another with: make PYTHON=/path/to/python3.12"; exit 1; }
	@[ "$$(uname -m)" != aarch64 ] || $(PYTHON) -c 'import sys; sys.exit(sys.version_info[:2] != (3, 12))' || \
	  echo "$(PYTHON) will not open a RealSense: on aarch64 its SDK is served for Python 3.12 alone. For a robot: make PYTHON=python3.12"

# Everything but PyTorch comes by the hashes of pip.lock, requirements.lock and development.lock. PyTorch and
# NVIDIA's libraries come by version, from the index that PIP_ARGS may name, because their builds differ from
# index to index. They come last: what else PyTorch needs is there by then, by its hash.
.venv/installed: pyproject.toml pip.lock requirements.lock torch.lock
	@echo "Looking up how much there is to install"
	$(PYTHON) -m venv .venv
	$(BIN)/python -m pip install --quiet --require-hashes --no-deps -r pip.lock
	@$(BIN)/python -m pip install --quiet --dry-run --no-deps --report .venv/torch.json $(PIP_ARGS) -c torch.lock torch >/dev/null
	@if grep -q '"nvidia-' .venv/torch.json; then size="3 GB to download, 6 GB on disk, many minutes" with='with CUDA$(WITH_CUDA)'; \
	else size="0.5 GB to download, 2 GB on disk, some minutes" with='without CUDA$(WITHOUT_CUDA)'; fi; \
	echo "Installing vizbot with its simulator into .venv: $$size. PyTorch comes $$with"
	$(BIN)/python -m pip install --quiet --require-hashes --no-deps -r requirements.lock
	$(BIN)/python -m pip install --quiet $(PIP_ARGS) -c torch.lock torch
	$(BIN)/python -m pip install --quiet --no-deps --no-build-isolation -e .
	@echo "Compiling what computes maps and ways: a minute or two"
	$(BIN)/python -c 'import vizbot.pipeline, vizbot.rehearsal.rig'
	@touch $@

.venv/developed: .venv/installed development.lock
	@echo "Adding what develops and tests vizbot: 0.5 GB more to download, 1.5 GB more on disk, a minute"
	$(BIN)/python -m pip install --quiet --require-hashes --no-deps -r development.lock
	@touch $@

# Node comes as a wheel: Debian's npm brings 400 packages.
.venv/page-tools: .venv/developed $(PAGE)/package-lock.json
	mkdir -p .venv/page && cp $(PAGE)/package.json $(PAGE)/package-lock.json .venv/page
	$(BIN)/npm ci --loglevel=error --prefix .venv/page
	@touch $@

# System packages only where they are missing. Some are optional: without furniture homes get plain shapes,
# without a browser, what the driver of the browser links to (libatomic1) and a voice, the tests of console
# and speech are skipped.
test test-slow test-benchmarks test-long: OPTIONAL += $(TESTED_WITH) $(shell command -v chromium >/dev/null || command -v chromium-browser >/dev/null || echo chromium)
check: OPTIONAL += $(NODE_WITH)
system:
	@missing=""; \
	$(PYTHON) -c 'import ensurepip' 2>/dev/null || \
	  missing=" $$($(PYTHON) -c 'import sys; print("python%d.%d-venv" % sys.version_info[:2])')"; \
	for package in $(RENDERING) $(OPTIONAL); do $(call installed,$$package) || missing="$$missing $$package"; done; \
	if [ -z "$$missing" ]; then exit 0; fi; \
	if ! command -v apt-get >/dev/null; then echo "Not installed here, and no apt-get to do it:$$missing"; exit 0; fi; \
	echo "Installing system packages:$$missing"; \
	sudo=""; [ "$$(id -u)" -eq 0 ] || sudo=sudo; \
	$$sudo apt-get update -qq || true; \
	for package in $$missing; do \
	  DEBIAN_FRONTEND=noninteractive $$sudo apt-get install -y -qq --no-install-recommends $$package >/dev/null || { \
	    case " $(OPTIONAL) " in \
	      *" $$package "*) echo "$$package cannot be had: what needs it is done without";; \
	      *) exit 1;; \
	    esac; }; \
	done

# The locks, from pyproject.toml and constraints.txt, for Python 3.11 to 3.14 on x86-64 and aarch64. What develops
# and tests is resolved with the rest, so that both have the same versions.
COMPILE = .venv/release/bin/uv pip compile --quiet --universal --python-version 3.11 --no-header --no-annotate
LOCK = $(COMPILE) --constraint constraints.txt pyproject.toml --extra sim --group build
ALL = --group dev --group page
HASHED = --generate-hashes $$(sed 's/==.*//; s/^/--no-emit-package /' torch.lock)
lock: .venv/release/installed
	echo pip | $(COMPILE) --generate-hashes --output-file pip.lock -
	$(LOCK) $(ALL) --output-file .venv/release/all.lock
	grep -E '^(torch|triton|cuda-[a-z]+|nvidia-[a-z0-9-]+)==' .venv/release/all.lock > torch.lock
	$(LOCK) $(ALL) $(HASHED) --output-file development.lock
	$(LOCK) $(HASHED) --constraint development.lock --output-file requirements.lock

# What an installation is made of, as CycloneDX.
sbom: .venv/installed .venv/release/installed
	.venv/release/bin/cyclonedx-py environment --pyproject pyproject.toml --output-file sbom.json $(BIN)/python

.venv/release/installed:
	$(PYTHON) -m venv .venv/release
	.venv/release/bin/python -m pip install --quiet uv==0.13.9 cyclonedx-bom==7.5.0
	@touch $@

clean:
	rm -rf .venv runs
