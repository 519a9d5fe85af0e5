"""What the programs of ROS refuse before any node runs: one table of commands, a case for each way of input."""
# mypy: ignore-errors

from __future__ import annotations

from lie_rigid_body.ros.evaluate import main as evaluate
from lie_rigid_body.ros.listen import main as listen
from lie_rigid_body.ros.sim import main as sim

FILES = {
    "existing.mcap": "precious",
    "broken.yaml": "/**: [",
    "bad.yaml": "/**:\n  ros__parameters:\n    inertia: [1.0, 1.0, 3.0]\n",
    "unknown.yaml": "/**:\n  ros__parameters:\n    speed: 1.0\n",
    "mixed.yaml": "/**:\n  ros__parameters:\n    inertia: [1, 2.5, 3]\n",
}
CLOCK = "-p sun_sensor_rate:=33.3 -p sun_sensor_clock_offset:=-100.0"
OF_EITHER = [
    "-p 'inertia:=[1.0, 1.0, 3.0]'",
    "-p 'initial_attitude_xyzw:=[0.0, 0.0, 0.0, 2.0]'",
    "-p rate:=.inf",
    "-p metod:=rkmk4",
    "-p rate:=",
    "-p record_path:=/no/such/folder/a.mcap",
    "-p record_path:=existing.mcap",
    "--params-file none.yaml",
    "--params-file broken.yaml",
    "--params-file bad.yaml",
    "--params-file unknown.yaml",
    "--fast",
]
"""Arguments that are refused both as our own and as those of ROS."""
COMMANDS = {
    2: [
        *(f"sim {given}" for given in OF_EITHER),
        *(f"sim --ros-args {given}" for given in OF_EITHER),
        "sim --scenario perpetual",
        f"sim -p epoch_ns:=5 -p record_path:=new.mcap {CLOCK}",
        "sim -p qos_overrides./pose.publisher.depth:=5",
        "sim -p use_sim_time:=true",
        *(f"sim --ros-args -p qos_overrides./pose.publisher.depth:={depth}" for depth in (0, -1, 2**31, 2**63 - 1)),
        "sim --ros-args -r pose",
        "sim --ros-args -r pose:=twist",
        "sim --ros-args -r twist:=/a -r ~/scenario:=/a",
        "sim --ros-args -r pose:=/rosout",
        "sim --ros-args -r twist:=/clock",
        "sim --ros-args -r ~/reset:=~/pause",
        "sim --ros-args -r ~/reset:=~/set_parameters",
        "sim --ros-args -r pose:=/a//b",
        f"sim --ros-args -r __node:={300 * 'n'}",
        f"sim --ros-args -r __node:={240 * 'n'}",
        "sim --ros-args --params-file /dev/zero",
        "sim --ros-args --params-file mixed.yaml",
        "evaluate --ros-args -r ~/error:=/diagnostics",
        "evaluate --ros-args -r /diagnostics:=/rosout",
        "evaluate --ros-args -p max_rmse:=1deg",
        "evaluate --ros-args -p max_rms:=1",
        "evaluate --ros-args -p covariance_axes:=map",
        "evaluate --duration -1",
        "evaluate --duration 1e300",
        "evaluate --truth a.mcap",
        "evaluate --topic pose:=/b",
        "evaluate --report no/such/folder/a.html",
        "listen --pose 'a b'",
        "listen --pose ''",
        "listen --reset 1/2",
        "listen --fast",
    ],
}


def prepare(folder):
    for name, text in FILES.items():
        (folder / name).write_text(text)


def run(words):
    return {"sim": sim, "evaluate": evaluate, "listen": listen}[words[0]](words[1:])
