# make demo, make test: everything they need is installed into .venv first.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/ready
NATIVE := native/Cargo.toml $(wildcard native/src/*.rs native/src/*/*.rs)

.PHONY: demo test check bench fuzz clean

demo: $(READY)
	$(BIN)/calibore demo

test: $(READY)
	$(BIN)/pytest -n 2 --dist loadfile

check: $(READY)
	$(BIN)/ruff check src tests benchmarks fuzzing examples
	$(BIN)/ruff format --check src tests benchmarks fuzzing examples
	$(BIN)/pyright
	$(BIN)/lint-imports

bench: $(READY)
	$(BIN)/python -m pip install --quiet --editable ".[peers]"
	$(BIN)/python -m benchmarks

# Ten minutes of the processor for each of the entries; make fuzz MINUTES=1 ENTRIES="png tables"
MINUTES ?= 10
fuzz: $(READY)
	$(BIN)/python -m fuzzing --minutes $(MINUTES) $(ENTRIES)

$(READY): pyproject.toml $(NATIVE)
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip
	$(BIN)/python -m pip install --quiet --editable ".[dev,export]"
	touch $(READY)

clean:
	rm -rf $(VENV) native/target native/fuzz/target build dist
