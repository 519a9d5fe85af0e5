"""How far is the attitude off after a while? This package beside what one would otherwise use, on one problem.

The problem: inertia 0.6, 0.8, 1 kg m², body rate 3, 0.5, −0.9 rad/s, against the 40-digit truth at 10 s and 1000 s.
Cost is given relative to the moving chart's, measured in the same run. Run it with

    python benchmarks/against_others.py

in an environment with scipy; MuJoCo is compared where it is installed (``pip install mujoco``).
"""

from __future__ import annotations

import importlib.util
import json
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

from lie_rigid_body import ClosedForm, MovingChart, RigidBody, State
from lie_rigid_body.lie import quaternion, so3

TRUTH = Path(__file__).resolve().parent.parent / "test" / "data" / "torque_free_truth.json"
TIMES_NS = (10_000_000_000, 1_000_000_000_000)
INERTIA = np.array([0.6, 0.8, 1.0])
RATE = np.array([3.0, 0.5, -0.9])
IDENTITY = np.array([0.0, 0.0, 0.0, 1.0])

Attitudes = list[np.ndarray]

MUJOCO_MODEL = """
<mujoco>
  <option timestep="{step}" gravity="0 0 0" integrator="{integrator}"/>
  <worldbody>
    <body><freejoint/><inertial pos="0 0 0" mass="1" diaginertia="0.6 0.8 1.0"/></body>
  </worldbody>
</mujoco>
"""


def truth() -> Attitudes:
    """The true attitudes, xyzw, at the times."""
    points = json.loads(TRUTH.read_text())["asymmetric"]["truth"]
    by_time = {point["t_ns"]: np.array([float(c) for c in point["attitude_xyzw"]]) for point in points}
    return [by_time[t] for t in TIMES_NS]


def moving_chart(method: str) -> Callable[[], Attitudes]:
    """This package, integrating."""
    return lambda: list(
        MovingChart(RigidBody(INERTIA), State(IDENTITY, RATE), method=method).at(TIMES_NS).attitude_xyzw
    )


def closed_form() -> Attitudes:
    """This package, evaluating."""
    return list(ClosedForm(RigidBody(INERTIA), State(IDENTITY, RATE)).at(TIMES_NS).attitude_xyzw)


def scipy_ivp(**options: object) -> Callable[[], Attitudes]:
    """Euler's equations and the quaternion's, as one system."""

    def rhs(_: float, y: np.ndarray) -> np.ndarray:
        x, q, z, w, a, b, c = y
        return np.array(
            [
                0.5 * (w * a + q * c - z * b),
                0.5 * (w * b + z * a - x * c),
                0.5 * (w * c + x * b - q * a),
                -0.5 * (x * a + q * b + z * c),
                (INERTIA[1] - INERTIA[2]) / INERTIA[0] * b * c,
                (INERTIA[2] - INERTIA[0]) / INERTIA[1] * c * a,
                (INERTIA[0] - INERTIA[1]) / INERTIA[2] * a * b,
            ]
        )

    def run() -> Attitudes:
        t = [1e-9 * n for n in TIMES_NS]
        end = solve_ivp(rhs, (0.0, t[-1]), [*IDENTITY, *RATE], t_eval=t, **options)
        return [q / np.linalg.norm(q) for q in end.y[:4].T]

    return run


def mujoco_run(integrator: str, step: float) -> Callable[[], Attitudes]:
    """A free joint without gravity."""
    import mujoco

    def run() -> Attitudes:
        model = mujoco.MjModel.from_xml_string(MUJOCO_MODEL.format(step=step, integrator=integrator))
        data = mujoco.MjData(model)
        data.qvel[3:] = RATE
        found = []
        done = 0
        for t in TIMES_NS:
            steps = round(t * 1e-9 / step)
            mujoco.mj_step(model, data, nstep=steps - done)
            done = steps
            w, x, y, z = data.qpos[3:]
            found.append(np.array([x, y, z, w]))
        return found

    return run


def contestants() -> Iterator[tuple[str, Callable[[], Attitudes]]]:
    """Names and runs; the moving chart first, as the measure of cost."""
    yield "lie_rigid_body moving chart, dmv20, 1 ms", moving_chart("dmv20")
    yield "lie_rigid_body moving chart, rkmk4, 1 ms", moving_chart("rkmk4")
    yield "lie_rigid_body closed form (2 evaluations)", closed_form
    yield "scipy solve_ivp, defaults", scipy_ivp()
    yield "scipy solve_ivp, DOP853, 1e-13", scipy_ivp(method="DOP853", rtol=1e-13, atol=1e-13)
    if importlib.util.find_spec("mujoco"):
        yield "MuJoCo free joint, Euler, 2 ms", mujoco_run("Euler", 0.002)
        yield "MuJoCo free joint, RK4, 2 ms", mujoco_run("RK4", 0.002)


def main() -> None:
    """Print the table."""
    exact = truth()
    print(f"{'':<44}{'error at 10 s':>15}{'at 1000 s':>12}{'cost':>9}")
    unit = 0.0
    for name, run in contestants():
        begin = time.perf_counter()
        found = run()
        cost = time.perf_counter() - begin
        unit = unit or cost
        errors = [
            float(so3.norm(quaternion.log(quaternion.multiply(quaternion.conjugate(e), quaternion.normalize(q)))))
            for e, q in zip(exact, found, strict=True)
        ]
        print(f"{name:<44}{errors[0]:>11.1e} rad{errors[1]:>8.0e} rad{cost / unit:>9.2g}")


if __name__ == "__main__":
    main()
