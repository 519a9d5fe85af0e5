"""What is not needed is not loaded: numba, which takes half a second, belongs to long work alone."""

from __future__ import annotations

import subprocess
import sys

NOT_NEEDED_FOR_HELP = {"numba", "llvmlite", "numpy", "scipy", "matplotlib"}
LOADED = "\nprint('loaded', *{name.partition('.')[0] for name in sys.modules})\n"
HELP = """
import sys
from lie_rigid_body.__main__ import main
assert main(['--help']) == 0
"""
HELP_OF_VERBS = """
for verb in ('record', 'check', 'evaluate', 'recover', 'plot', 'scenarios', 'explain'):
    main([verb, '--help'])
"""
SOME_STEPS = """
from lie_rigid_body import ClosedForm, MovingChart, RigidBody, State
body, start = RigidBody([1, 2, 3]), State([0, 0, 0, 1], [0, 1, 0.1])
ClosedForm(body, start).at(range(1000))
for method in ('dmv20', 'rkmk4'):
    MovingChart(body, start, method=method).at(10**9)
"""
EVERY_MODULE = """
import importlib, pkgutil, lie_rigid_body
for module in pkgutil.walk_packages(lie_rigid_body.__path__, 'lie_rigid_body.'):
    left_out = ('lie_rigid_body.ros', 'lie_rigid_body.proof')  # need rclpy and python-flint
    if not module.name.startswith(left_out) and not module.name.endswith('__main__'):
        importlib.import_module(module.name)
"""


def test_help_loads_nothing_heavy_and_no_module_loads_numba() -> None:
    code = LOADED.join((HELP, HELP_OF_VERBS + SOME_STEPS + EVERY_MODULE, ""))
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    first, last = (set(line.split()) for line in done.stdout.splitlines() if line.startswith("loaded "))
    assert not first & NOT_NEEDED_FOR_HELP
    assert {"numpy", "matplotlib"} <= last
    assert not last & {"numba", "llvmlite"}
