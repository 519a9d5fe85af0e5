"""What is not needed is not loaded: numba, which takes half a second, belongs to long work alone."""

from __future__ import annotations

import json
import subprocess
import sys

LOADED = "import json, sys; json.dump(sorted({name.partition('.')[0] for name in sys.modules}), sys.stderr)"
EVERY_MODULE = """
import importlib, pkgutil, lie_rigid_body
for module in pkgutil.walk_packages(lie_rigid_body.__path__, 'lie_rigid_body.'):
    left_out = ('lie_rigid_body.ros', 'lie_rigid_body.proof')  # need rclpy and python-flint
    if not module.name.startswith(left_out) and not module.name.endswith('__main__'):
        importlib.import_module(module.name)
"""
NOT_NEEDED_FOR_HELP = {"numba", "llvmlite", "numpy", "scipy", "matplotlib"}
VERBS = ["record", "check", "evaluate", "recover", "plot", "scenarios", "explain"]


def loaded(code: str) -> set[str]:
    """The packages that a process has loaded at its end."""
    done = subprocess.run([sys.executable, "-c", code + LOADED], capture_output=True, text=True, check=True)
    return set(json.loads(done.stderr))


def test_no_module_of_the_package_loads_numba():
    assert not loaded(EVERY_MODULE) & {"numba", "llvmlite"}


def test_help_loads_nothing_heavy():
    code = "from lie_rigid_body.__main__ import main\nassert main(['--help']) == 0\n"
    assert not loaded(code) & NOT_NEEDED_FOR_HELP


def test_help_of_a_verb_loads_no_numba():
    calls = "".join(f"main(['{verb}', '--help'])\n" for verb in VERBS)
    code = f"from lie_rigid_body.__main__ import main\n{calls}"
    assert not loaded(code) & {"numba", "llvmlite"}


def test_constructing_a_motion_and_taking_some_steps_loads_no_numba():
    code = """
from lie_rigid_body import ClosedForm, MovingChart, RigidBody, State
body, start = RigidBody([1, 2, 3]), State([0, 0, 0, 1], [0, 1, 0.1])
ClosedForm(body, start).at(range(1000))
for method in ('dmv20', 'rkmk4'):
    MovingChart(body, start, method=method).at(10**9)
"""
    assert not loaded(code) & {"numba", "llvmlite"}
