"""Genesis: a body at a free joint, in double precision on the CPU. Its free joint takes rates in the body's axes.

Returned rates are in the world's axes.
"""

from __future__ import annotations

from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory

import genesis
import numpy as np

from judged.mujoco_joint import model_text
from judged.own import Answer
from lie_rigid_body.conformance import EngineCase
from lie_rigid_body.conformance.results import Simulate
from lie_rigid_body.lie import quaternion


def engines() -> Iterator[tuple[str, Simulate]]:
    genesis.init(backend=genesis.cpu, precision="64", logging_level="error")
    yield f"Genesis {version('genesis-world')}", simulate


def simulate(case: EngineCase, step: float) -> Answer:
    scene = genesis.Scene(
        sim_options=genesis.options.SimOptions(dt=step, gravity=(0.0, 0.0, 0.0)),
        rigid_options=genesis.options.RigidOptions(enable_collision=False, enable_joint_limit=False),
        show_viewer=False,
    )
    with TemporaryDirectory() as folder:
        model = Path(folder, "body.xml")
        model.write_text(model_text(case, step, "Euler"))
        body = scene.add_entity(genesis.morphs.MJCF(file=str(model), align=False))
        scene.build()
    body.set_quat(case.attitude_wxyz.copy())
    body.set_dofs_velocity(np.concatenate([np.zeros(3), case.body_rate]))
    count = round(case.duration / step)
    attitude, rate = np.empty((count, 4)), np.empty((count, 3))
    for n in range(count):
        scene.step()
        attitude[n] = np.roll(body.get_quat().numpy(), -1)
        rate[n] = body.get_ang().numpy()
    scene.destroy()
    return step * np.arange(1, count + 1), attitude, quaternion.rotate(quaternion.conjugate(attitude), rate)
