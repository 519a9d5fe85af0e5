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


def prepare(folder):
    for name, text in FILES.items():
        (folder / name).write_text(text)


def run(words):
    return {"sim": sim, "evaluate": evaluate, "listen": listen}[words[0]](words[1:])
