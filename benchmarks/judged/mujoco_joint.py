"""MuJoCo: a body at a free joint, whose inertia has a frame of its own. Rates are in the body's axes."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import mujoco
import numpy as np

from judged.own import Answer
from lie_rigid_body.conformance import EngineCase
from lie_rigid_body.conformance.results import Simulate
from peers.mujoco_joint import INTEGRATORS

VERSION = mujoco.__version__
MODEL = """
<mujoco>
  <option timestep="{step!r}" gravity="0 0 0" integrator="{integrator}">
    <flag contact="disable" constraint="disable" warmstart="disable" autoreset="disable"/>
  </option>
  <worldbody>
    <body><freejoint/><inertial pos="0 0 0" mass="1" diaginertia="{moments}" quat="{frame}"/></body>
  </worldbody>
</mujoco>
"""


def engines() -> Iterator[tuple[str, Simulate]]:
    """Each integrator."""
    for integrator in INTEGRATORS:
        yield f"MuJoCo {VERSION}, {integrator}", partial(simulate, integrator=integrator)


def model_text(case: EngineCase, step: float, integrator: str) -> str:
    numbers = {"moments": case.principal_moments, "frame": case.inertial_frame_wxyz}
    text = {name: " ".join(map(repr, value.tolist())) for name, value in numbers.items()}
    return MODEL.format(step=step, integrator=integrator, **text)


def model_of(case: EngineCase, step: float, integrator: str) -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(model_text(case, step, integrator))


def simulate(case: EngineCase, step: float, integrator: str) -> Answer:
    model = model_of(case, step, integrator)
    data = mujoco.MjData(model)
    data.qpos[3:] = case.attitude_wxyz
    data.qvel[3:] = case.body_rate
    count = round(case.duration / step)
    attitude, rate = np.empty((count, 4)), np.empty((count, 3))
    for n in range(count):
        mujoco.mj_step(model, data)
        attitude[n] = data.qpos[[4, 5, 6, 3]]
        rate[n] = data.qvel[3:]
    return step * np.arange(1, count + 1), attitude, rate
