"""MuJoCo: a free joint, without gravity and with everything switched off that the task does not need."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, Final

import mujoco
import numpy as np
from mujoco import rollout
from numpy.typing import NDArray

from peers.contender import Contender, step_text
from peers.task import NS, RATE, Task

STEPS: Final = (0.05, 0.02, 0.01, 0.005, 0.002, 0.001, 0.0005)
SHORTER_STEPS: Final = (0.0001,)
"""For the integrators of first order: that of fourth order is at round-off long before."""

FIRST_ORDER: Final = ("Euler", "implicit", "implicitfast")
INTEGRATORS: Final = (*FIRST_ORDER, "RK4")

MODEL: Final = """
<mujoco>
  <option timestep="{step}" gravity="0 0 0" integrator="{integrator}">
    <flag constraint="disable" contact="disable" actuation="disable" spring="disable" damper="disable"
          gravity="disable" sensor="disable" warmstart="disable" autoreset="disable"/>
  </option>
  <worldbody>
    <body><freejoint/><inertial pos="0 0 0" mass="1" diaginertia="0.6 0.8 1.0"/></body>
  </worldbody>
</mujoco>
"""
XYZW: Final = (4, 5, 6, 3)
"""Where a free joint's position holds the quaternion, which MuJoCo writes scalar first."""


# Of a step that leads to infinity it would write a log into the folder of the caller.
mujoco.set_mju_user_warning(lambda _: None)


def contenders(task: Task) -> Iterator[Contender]:
    """Each integrator at each step that fits."""
    for integrator in INTEGRATORS:
        for step in (*STEPS, *SHORTER_STEPS) if integrator in FIRST_ORDER else STEPS:
            if step <= task.smallest_interval:
                yield Contender(f"MuJoCo, {integrator}", step_text(step), step, _runner(task, integrator, step))


def _runner(task: Task, integrator: str, step: float) -> Callable[[], NDArray[np.float64]]:
    model = mujoco.MjModel.from_xml_string(MODEL.format(step=step, integrator=integrator))
    data = mujoco.MjData(model)
    counts = np.rint(np.diff(task.times_ns, prepend=0) / (NS * step)).astype(int)
    steps = _stored if len(set(counts.tolist())) == 1 else _skipped

    def run() -> NDArray[np.float64]:
        mujoco.mj_resetData(model, data)
        data.qvel[3:] = RATE
        return steps(model, data, counts)

    return run


def _skipped(model: Any, data: Any, counts: NDArray[np.int64]) -> NDArray[np.float64]:
    """The steps between two times in one compiled loop."""
    found = np.empty((len(counts), 4))
    for row, count in zip(found, counts.tolist(), strict=True):
        mujoco.mj_step(model, data, nstep=count)
        row[:] = data.qpos[list(XYZW)]
    return found


def _stored(model: Any, data: Any, counts: NDArray[np.int64]) -> NDArray[np.float64]:
    """All steps in one compiled loop, which stores every state."""
    kind = mujoco.mjtState.mjSTATE_FULLPHYSICS
    start = np.empty((1, mujoco.mj_stateSize(model, kind)))
    mujoco.mj_getState(model, data, start[0], kind)
    states, _ = rollout.rollout(model, data, initial_state=start, nstep=int(counts.sum()))
    # the state begins with the time
    return states[0, counts[0] - 1 :: counts[0], [1 + i for i in XYZW]].T
