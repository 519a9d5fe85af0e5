"""Newton: a free body by solvers for rigid bodies, in single precision on the CPU. Rates are in the world's axes."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import newton
import numpy as np
import warp

from judged.own import Answer
from lie_rigid_body.conformance.cases import EngineCase
from lie_rigid_body.conformance.results import Simulate
from lie_rigid_body.lie import quaternion

SOLVERS = ("SolverXPBD", "SolverSemiImplicit")
"""Solvers that take a body without a joint. Their angular damping, which is on by default, is switched off."""
warp.config.quiet = True


def engines() -> Iterator[tuple[str, Simulate]]:
    for solver in SOLVERS:
        yield f"Newton {newton.__version__}, {solver}", partial(simulate, solver=solver)


def simulate(case: EngineCase, step: float, solver: str) -> Answer:
    builder = newton.ModelBuilder(gravity=(0.0, 0.0, 0.0))
    start = warp.transform((0.0, 0.0, 0.0), warp.quat(*case.attitude_xyzw.tolist()))
    builder.add_body(xform=start, mass=1.0, inertia=warp.mat33(*case.inertia.ravel().tolist()), lock_inertia=True)
    with warp.ScopedDevice("cpu"):
        model = builder.finalize(device="cpu")
    engine = getattr(newton.solvers, solver)(model, angular_damping=0.0)
    now, after = model.state(), model.state()
    now.body_qd.assign(np.concatenate([np.zeros(3), case.world_rate])[np.newaxis].astype(np.float32))
    control = model.control()
    count = round(case.duration / step)
    attitude, rate = np.empty((count, 4)), np.empty((count, 3))
    for n in range(count):
        now.clear_forces()
        engine.step(now, after, control, None, step)
        now, after = after, now
        attitude[n] = now.body_q.numpy()[0, 3:]
        rate[n] = now.body_qd.numpy()[0, 3:]
    with np.errstate(all="ignore"):  # where it diverges
        attitude = quaternion.normalize(attitude)
    return step * np.arange(1, count + 1), attitude, quaternion.rotate(quaternion.conjugate(attitude), rate)
