"""MJX: MuJoCo in JAX, in single precision, by one compiled loop."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from importlib.metadata import version
from typing import Any

import jax
import mujoco
import numpy as np
from mujoco import mjx

from judged.mujoco_joint import model_of
from judged.own import Answer
from lie_rigid_body.conformance import EngineCase
from lie_rigid_body.conformance.results import Simulate

VERSION = version("mujoco-mjx")
MAX_STEPS = 2048


def engines() -> Iterator[tuple[str, Simulate]]:
    for integrator in ("Euler", "implicitfast", "RK4"):
        yield f"MJX {VERSION}, {integrator}", partial(simulate, integrator=integrator)


@jax.jit
def run(world: Any, data: Any) -> Any:
    def step(data: Any, _: None) -> Any:
        data = mjx.step(world, data)
        return data, (data.qpos[3:], data.qvel[3:])

    return jax.lax.scan(step, data, None, length=MAX_STEPS)[1]


def simulate(case: EngineCase, step: float, integrator: str) -> Answer:
    model = model_of(case, step, integrator)
    data = mujoco.MjData(model)
    data.qpos[3:] = case.attitude_wxyz
    data.qvel[3:] = case.body_rate
    attitude, rate = run(mjx.put_model(model), mjx.put_data(model, data))
    count = round(case.duration / step)
    assert count <= MAX_STEPS
    quaternions = np.asarray(attitude, dtype=float)[:count]
    return step * np.arange(1, count + 1), np.roll(quaternions, -1, axis=1), np.asarray(rate, dtype=float)[:count]
