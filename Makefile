# Every target sets up what it needs, inside this folder and nowhere else.
#
# PYTHON=/path/to/python names the Python to build environments from; without it one is looked for.
# PYTHON_ROS=none pretends that there is no Python 3.12, which the live node needs.

export PYTHON PYTHON_ROS

# Caches and logs that would otherwise land in the home folder.
export PIP_CACHE_DIR ?= $(CURDIR)/.cache/pip
export XDG_CACHE_HOME := $(CURDIR)/.cache
export MPLCONFIGDIR := $(CURDIR)/.cache/matplotlib
export ROS_LOG_DIR := $(CURDIR)/.cache/ros-log

# A sourced ROS 2 would mix its libraries with those of the environment.
unexport PYTHONHOME PYTHONPATH LD_LIBRARY_PATH AMENT_PREFIX_PATH RMW_IMPLEMENTATION _ROS_WHEELS_BOOTSTRAP_COMPLETE

.PHONY: help sim quick test test-slow test-oldest test-kilted words fuzz lint docs bench papers league clean

help:
	@echo "make sim          run the live node        ARGS='--ros-args -p rate:=200.0' is passed on"
	@echo "make quick        the loop of editing, within a minute: lint, and of most tests one case"
	@echo "make test         lint, and run the tests  ARGS='-k name' is passed on to pytest"
	@echo "make test-slow    the tests that make test leaves out as too long, some minutes"
	@echo "make test-oldest  the tests on the library versions of Ubuntu 24.04 (ROS 2 Jazzy)"
	@echo "make test-kilted  the tests of the node with the client library of ROS 2 Kilted, on Python 3.13 or 3.14"
	@echo "make words        write what the package says into test/words/words.txt anew, for a review to show"
	@echo "make fuzz         mutated files into every verb, ten minutes    ARGS='--minutes 60'; failing ones stay in test/fuzzed"
	@echo "make lint         check style and types"
	@echo "make docs         build the site of docs/ and of the docstrings into build/docs"
	@echo "make bench        run beside other software    ARGS=--save also writes the pictures and tables of docs/"
	@echo "make papers       published numbers of free rotations beside ours, each with its source and the lines that make it"
	@echo "make league       score attitude filters of PyPI, over an hour    ARGS=--save also writes docs/reference/league.md"
	@echo "make clean        remove environments, caches and build folders"

sim:
	@exec scripts/sim.sh $(ARGS)

quick:
	@exec scripts/quick.sh $(ARGS)

test: lint
	@exec scripts/test.sh newest $(ARGS)

test-slow:
	@exec scripts/test.sh newest -m slow $(ARGS)

test-oldest:
	@exec scripts/test.sh oldest $(ARGS)

test-kilted:
	@exec scripts/test.sh kilted $(ARGS)

words:
	@exec scripts/test.sh newest --write-words test/words -n 0 $(ARGS)

fuzz:
	@exec scripts/fuzz.sh $(ARGS)

lint:
	@exec scripts/lint.sh

docs:
	@exec scripts/docs.sh

bench:
	@exec scripts/bench.sh bench $(ARGS)

papers:
	@exec scripts/papers.sh $(ARGS)

league:
	@exec scripts/bench.sh league $(ARGS)

clean:
	rm -rf .venv .venv-headless .venv-oldest .venv-kilted .venv-docs .venv-bench .venv-league .cache build install log dist *.egg-info
	rm -rf .hypothesis .mypy_cache .pytest_cache .ruff_cache
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
