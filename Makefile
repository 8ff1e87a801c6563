# Every target sets up what it needs on a machine with Python >= 3.10, Rust and make.
# Everything is written below this folder: .venv/, target/, dist/.

PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
PY     := $(BIN)/python
export VIRTUAL_ENV := $(abspath $(VENV))
export PIP_DISABLE_PIP_VERSION_CHECK := 1
# Thread pools of NumPy's BLAS fight over two cores; lcpstar itself threads across problems.
export OPENBLAS_NUM_THREADS ?= 1
export OMP_NUM_THREADS ?= 1

RUST_SOURCES := $(shell find rust -name '*.rs' -o -name Cargo.toml -o -name README.md) Cargo.toml Cargo.lock

.PHONY: help demo build test test-rust test-python lint fmt bench bench-deps bench-rust bench-tradeoff corpus stress stress-record fuzz miri soak \
	coverage wheel docs all clean

help: ## list the targets
	@grep -E '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 16

$(VENV)/.dev: pyproject.toml
	$(PYTHON) -m venv $(VENV)
	$(PY) -m pip install --quiet --upgrade 'pip>=25.1'
	$(PY) -m pip install --quiet --group dev 'numpy>=1.23'
	@touch $@

$(VENV)/.build: $(VENV)/.dev $(RUST_SOURCES) pyproject.toml
	$(BIN)/maturin develop --release --quiet
	@touch $@

build: $(VENV)/.build ## compile the extension into .venv

demo: build ## the main job: the paper, a PPT, a verdict, a stack of boxes
	@$(PY) examples/demo.py

test: test-rust test-python ## all tests

test-rust:
	cargo test --quiet --release --workspace --exclude lcpstar-py
	cd examples/rust-crate && cargo run --quiet --target-dir ../../target

test-python: build
	$(BIN)/pytest

STRESS ?= --count 300000 --large 2
DOORS  ?= --count 10000
stress: build ## attack every method and every door, score the answers exactly (half an hour; STRESS="--count N --seed S ...", DOORS="...")
	cargo run --quiet --release -p lcpstar-stress -- $(STRESS)
	$(PY) benches/doors.py $(DOORS)

stress-record: build ## the same, and write docs/stress.md and benches/record/stress.md
	cargo run --quiet --release -p lcpstar-stress -- $(STRESS) --record .
	$(PY) benches/doors.py $(DOORS) --record .

lint: build ## formatting, clippy, ruff, mypy, stubs, Rust docs
	cargo fmt --all --check
	cargo clippy --quiet --release --workspace --all-targets -- -D warnings
	RUSTDOCFLAGS="-D warnings" cargo doc --quiet --release --no-deps --workspace --exclude lcpstar-py --exclude lcpstar-stress
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/stubtest lcpstar._core

fmt: $(VENV)/.dev ## format Rust and Python
	cargo fmt --all
	$(BIN)/ruff check --fix-only --quiet .
	$(BIN)/ruff format --quiet .

$(VENV)/.bench: $(VENV)/.dev
	$(PY) -m pip install --quiet --group bench
	@touch $@

bench-deps: $(VENV)/.bench ## the peers that benchmarks compare with

bench: build $(VENV)/.bench ## benchmarks beside peers, recorded in benches/record/
	$(PY) benches/run.py

bench-rust: ## the core without Python, recorded; AGAINST=COMMIT compares with that commit instead
	$(PYTHON) benches/rust.py $(if $(AGAINST),--against $(AGAINST))

corpus: build ## every problem of $$LCPSTAR_CORPUS solved and proved; writes docs/corpus.md
	cd benches && ../$(PY) corpus.py

bench-tradeoff: build ## every method at every tolerance, recorded with plots; about 10 minutes
	$(PY) benches/tradeoff.py

TIME ?= 600
FUZZ := target/release/lcpstar-fuzz
fuzz: ## coverage-guided fuzzing of the core for TIME=600 seconds; needs a C++ compiler
	cd fuzz && RUSTC_WRAPPER=$(abspath fuzz/rustc.sh) cargo build --release --target-dir ../target
	mkdir -p target/fuzz/corpus target/fuzz/findings
	tar -xzf fuzz/corpus.tar.gz -C target/fuzz/corpus
	$(FUZZ) target/fuzz/corpus -fork=1 -ignore_crashes=1 -ignore_timeouts=1 -max_total_time=$(TIME) -timeout=120 \
		-max_len=800 -len_control=20 -artifact_prefix=target/fuzz/findings/

miri: ## the unsafe code under Miri, and under AddressSanitizer on the machine's own instructions; needs nightly
	cd fuzz/miri && RUSTFLAGS="-Ctarget-feature=+avx2,+fma" cargo +nightly miri test --target-dir ../../target/miri
	cd fuzz/miri && RUSTFLAGS="-Zsanitizer=address -Ctarget-cpu=native" \
		cargo +nightly test --lib --target x86_64-unknown-linux-gnu --target-dir ../../target/asan

coverage: build ## lines and branches of the core reached by both test suites; needs llvm-tools
	$(PY) benches/core_coverage.py

soak: build ## a million calls, threads, forks, interrupts, shutdowns
	$(PY) benches/soak.py

wheel: $(VENV)/.dev ## an abi3 wheel in dist/
	$(BIN)/maturin build --profile dist --out dist

all: lint test demo ## what CI runs, and the demo

clean: ## remove what the targets made
	rm -rf $(VENV) target dist
