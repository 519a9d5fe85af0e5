"""The launch file loads, and hands on what it is given and nothing else."""

from __future__ import annotations

import runpy
import sys
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType, SimpleNamespace

import pytest

LAUNCH_FILE = Path(__file__).parents[2] / "launch" / "sim.launch.py"


def modules_with(**names: object) -> dict[str, ModuleType]:
    """Stand-ins for the launch libraries, which PyPI does not have."""
    found = {}
    for name in ("launch", "launch.actions", "launch.substitutions", "launch_ros", "launch_ros.actions"):
        found[name] = ModuleType(name)
        found[name].__dict__.update(names)
    return found


@pytest.mark.parametrize(
    ("given", "arguments", "parameters", "namespace"),
    [
        ({}, [], [], ""),
        (
            {"scenario": "dzhanibekov", "params_file": "p.yaml", "namespace": "a", "record_path": "a.mcap"},
            ["--scenario", "dzhanibekov", "--params-file", "p.yaml"],
            [{"record_path": "a.mcap"}],
            "a",
        ),
    ],
)
def test_what_is_given_reaches_the_node(
    monkeypatch: pytest.MonkeyPatch,
    given: dict[str, str],
    arguments: list[str],
    parameters: list[dict[str, str]],
    namespace: str,
) -> None:
    stand_ins = modules_with(
        LaunchContext=object,
        LaunchDescription=lambda actions: actions,
        DeclareLaunchArgument=lambda name, default_value, description: (name, default_value),
        OpaqueFunction=lambda function: function,
        LaunchConfiguration=lambda name: SimpleNamespace(perform=lambda context: context.get(name, "")),
        Node=lambda **settings: settings,
    )
    for name, module in stand_ins.items():
        monkeypatch.setitem(sys.modules, name, module)
    *declared, function = runpy.run_path(str(LAUNCH_FILE))["generate_launch_description"]()
    assert {name for name, _ in declared} == {"scenario", "params_file", "namespace", "record_path"}
    [node] = function(given)
    assert (node["package"], node["executable"]) == ("lie_rigid_body", "sim")
    assert (node["arguments"], node["parameters"], node["namespace"]) == (arguments, parameters, namespace)


@pytest.mark.skipif(find_spec("launch_ros") is None, reason="launch_ros is not installed: PyPI does not have it")
def test_it_loads_with_the_real_libraries() -> None:
    description = runpy.run_path(str(LAUNCH_FILE))["generate_launch_description"]()
    assert len(description.entities) == 5
