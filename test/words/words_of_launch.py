"""What the launch files start, and refuse: half of what was asked for is worse than nothing."""
# mypy: ignore-errors

from __future__ import annotations

from pathlib import Path

from launched import described, launched

from lie_rigid_body.scenario.parameter_table import PARAMETERS

ESTIMATOR = "estimator.launch.py"
VIEW = {"rviz": "true"}
OWN = {"package": "mine", "executable": "filter"}
TOP = {"scenario": "dzhanibekov", "namespace": "a", "name": "top"}
GIVEN = {"rate": "200.0", "inertia": "[1.0, 2.0, 3.0]", "record_path": "a.mcap", "body_frame": "a/base_link"}
TOPICS = {"remappings": "imu:=imu/data_raw", "estimate": "/mine/pose", "namespace": "a"}
LIMITS = {"max_rms": "1deg", "max_after": "1s:3deg 10s:2deg", "duration": "60", "report": "a.html"}
FILTER = {**OWN, "parameters": "gain:=0.5 field:='[1.0, 2.0]'", **TOPICS, **LIMITS, "covariance_axes": "body"}
LOCKED = {"lockstep": "true", "estimate": "attitude", "namespace": "a", "real_time_factor": "0.0"}


def started(file, **given):
    """The nodes that are started, a line for each of their settings."""
    lines = []
    for node in launched(file, Path.cwd(), **given):
        lines += [f"{key}: {value}" for key, value in node.items() if not callable(value)]
    return "\n".join(lines)


def file():
    """A parameter file."""
    Path("p.yaml").write_text("/**: {ros__parameters: {imu_rate: 20.0}}")
    return "p.yaml"


def declared(launch):
    """The arguments of a launch file, but for parameters of the node, which describe themselves."""
    parameters = {parameter.name for parameter in PARAMETERS}
    *arguments, _ = described(launch)
    own = [
        f"{name} = {settings['default_value']!r}, {settings.get('choices', 'any')}: {settings['description']}"
        for name, settings in arguments
        if name not in parameters
    ]
    missing = parameters.difference(name for name, settings in arguments if settings["description"])
    return "\n".join([*own, f"{len(arguments) - len(own)} parameters of the node, all but {sorted(missing)}"])


def sim(**given):
    return started("sim.launch.py", **given)


def bodies(**given):
    return started("bodies.launch.py", **given)


def estimator(**given):
    return started(ESTIMATOR, **given)


REFUSED = {
    ValueError: [
        lambda: bodies(bodies="a:dzhanibekov,a:symmetric_top"),
        lambda: bodies(bodies=":top"),
        lambda: bodies(bodies="a/b:top"),
        lambda: bodies(bodies="a:dzanibekov"),
        lambda: bodies(spacing="wide"),
        lambda: bodies(params_file="/nowhere.yaml"),
        lambda: bodies(record_path="a.mcap"),
        lambda: sim(scenario="dzanibekov"),
        lambda: sim(rate="-1.0"),
        lambda: sim(rte="1.0"),
        *(lambda part=part: sim(**VIEW, without=part) for part in ("lie_rigid_body", "rviz2")),
        *(lambda part=part: bodies(**VIEW, without=part) for part in ("lie_rigid_body", "rviz2", "tf2_ros")),
        lambda: estimator(package="mine"),
        lambda: estimator(max_rms="1"),
        lambda: estimator(covariance_axes="map"),
        lambda: estimator(max_after="10s"),
        lambda: estimator(parameters="gain=1"),
        lambda: estimator(remappings="imu=data"),
        lambda: estimator(imu_rate="-1.0"),
        lambda: estimator(rviz="true"),
        *(lambda part=part: estimator(**OWN, without=part) for part in ("lie_rigid_body", "mine")),
    ],
}
SAID = [
    lambda: declared("sim.launch.py"),
    lambda: declared("bodies.launch.py"),
    lambda: declared(ESTIMATOR),
    lambda: sim(),
    lambda: sim(params_file=file(), namespace="/lab/a", record="true"),
    lambda: sim(**TOP, **GIVEN, record="true"),
    lambda: sim(namespace="a", rviz="true", world_frame="map"),
    lambda: sim(**VIEW, without="tf2_ros"),
    lambda: sim(**{"launch-prefix": "nice"}),
    lambda: bodies(),
    lambda: bodies(bodies="a:dzhanibekov, b:symmetric_top,c", spacing="2", rate="200.0"),
    lambda: estimator(package="imu_filter_madgwick"),
    lambda: estimator(package="imu_complementary_filter"),
    lambda: estimator(**FILTER),
    lambda: estimator(**OWN, params_file=file()),
    lambda: estimator(**OWN, **LOCKED),
    lambda: estimator(**OWN, lockstep="true", lockstep_nodes="[/recorder]", lockstep_timeout="2.0"),
]
