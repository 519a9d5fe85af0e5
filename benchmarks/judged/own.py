"""Integrators as engines have them, right and with each mistake put in, by which `judge` is measured and tested.

They are compiled where numba is installed. In single precision every vector is rounded as it is made.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.conformance import EngineCase
from lie_rigid_body.lie import quaternion

try:
    import numba

    compiled: Any = numba.njit(error_model="numpy")
except ImportError:

    def compiled(function: Any) -> Any:
        """The function itself."""
        return function


Array = NDArray[Any]
"""Of float64 or float32."""
Answer = tuple[Array, Array, Array]

MISTAKES: Final = {
    "": "",
    "no gyroscopic term": "gyroscopic_term_missing",
    "no gyroscopic term, world rates returned": "gyroscopic_term_missing",
    "gyroscopic term of the opposite sign": "gyroscopic_term_sign",
    "body rate given as world rate": "rate_axes",
    "world rate given as body rate": "rate_axes",
    "world rates returned": "rate_axes",
    "world rates taken and returned": "rate_axes",
    "moments along the body's axes": "inertia_axes",
    "moments in descending order": "inertia_axes",
    "frame inverted": "inertia_axes",
    "products left out": "inertia_axes",
    "products negated": "inertia_axes",
    "inertia in world axes": "inertia_axes",
    "damping": "damped",
    "damping at each step": "damped",
    "negative damping": "energy_grows",
    "momentum clamped": "toward_intermediate",
}
"""Code that each mistake should be given."""
EXPLICIT: Final = ("explicit Euler", "semi-implicit Euler", "explicit midpoint")
"""Integrators whose energy a clamped momentum leads to the intermediate axis. Others keep it, or lead it away."""
DAMPING: Final = 0.03
"""Share of the rate that is lost in a period."""
DAMPING_OF_A_STEP: Final = 0.001


@compiled
def cross(a, b):
    c = np.empty_like(a)
    c[0] = a[1] * b[2] - a[2] * b[1]
    c[1] = a[2] * b[0] - a[0] * b[2]
    c[2] = a[0] * b[1] - a[1] * b[0]
    return c


@compiled
def times(matrix, v):
    c = np.empty_like(v)
    for i in range(3):
        c[i] = matrix[i, 0] * v[0] + matrix[i, 1] * v[1] + matrix[i, 2] * v[2]
    return c


@compiled
def plus(a, h, b):
    """The sum a + h b, rounded as its numbers are."""
    c = np.empty_like(a)
    for i in range(len(a)):
        c[i] = a[i] + h * b[i]
    return c


@compiled
def product(p, v, s):
    """The product of a quaternion x y z w with one of vector v and scalar s."""
    c = np.empty_like(p)
    c[0] = p[3] * v[0] + p[0] * s + p[1] * v[2] - p[2] * v[1]
    c[1] = p[3] * v[1] - p[0] * v[2] + p[1] * s + p[2] * v[0]
    c[2] = p[3] * v[2] + p[0] * v[1] - p[1] * v[0] + p[2] * s
    c[3] = p[3] * s - p[0] * v[0] - p[1] * v[1] - p[2] * v[2]
    return c


@compiled
def unit(q):
    return plus(0 * q, 1 / np.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]), q)


@compiled
def turn(q, h, w):
    """Rotate an attitude by h w, in the body's axes."""
    half = 0.5 * h * np.sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2])
    ratio = 0.5 * h * (np.sin(half) / half if half != 0.0 else 1.0)
    return unit(product(q, plus(0 * w, ratio, w), np.cos(half)))


@compiled
def derivative(q, w):
    return plus(0 * q, 0.5, product(q, w, 0.0))


@compiled
def acceleration(world, w):
    """Euler's equations, with what a mistake makes of them."""
    M, J, gyroscopic, damping = world
    torque = times(J, cross(times(M, w), w))
    return plus(plus(0 * w, gyroscopic, torque), -damping, w)


@compiled
def implicit(world, start, h):
    """Solve w = start + h a(w) by iteration."""
    w = start
    for _ in range(60):
        before = w
        w = plus(start, h, acceleration(world, before))
        if np.abs(w - before).max() <= 1e-16 * np.abs(w).max():
            break
    return w


@compiled
def explicit_euler(world, q, w, h):
    return unit(plus(q, h, derivative(q, w))), plus(w, h, acceleration(world, w))


@compiled
def semi_implicit_euler(world, q, w, h):
    after = plus(w, h, acceleration(world, w))
    return turn(q, h, after), after


@compiled
def implicit_euler(world, q, w, h):
    after = implicit(world, w, h)
    return turn(q, h, after), after


@compiled
def lie_euler(world, q, w, h):
    """The body momentum is carried by the rotation of the step: in the world it stays."""
    M, J, gyroscopic, damping = world
    one = 0 * q
    one[3] = 1.0
    back = turn(one, -h * gyroscopic, w)
    p = times(M, w)
    axis = back[:3]
    twice = plus(0 * p, 2.0, cross(axis, p))
    carried = plus(plus(p, back[3], twice), 1.0, cross(axis, twice))
    return turn(q, h, w), plus(0 * w, 1.0 - h * damping, times(J, carried))


@compiled
def explicit_midpoint(world, q, w, h):
    middle = plus(w, h / 2, acceleration(world, w))
    return turn(q, h, middle), plus(w, h, acceleration(world, middle))


@compiled
def implicit_midpoint(world, q, w, h):
    middle = implicit(world, w, h / 2)
    return turn(q, h, middle), plus(-w, 2.0, middle)


@compiled
def newmark(world, q, w, h):
    """The explicit Lie–Newmark method, whose rate is implicit in the second half of a step."""
    middle = plus(w, h / 2, acceleration(world, w))
    return turn(q, h, middle), implicit(world, middle, h / 2)


@compiled
def rk4(world, q, w, h):
    a1 = acceleration(world, w)
    w2 = plus(w, h / 2, a1)
    a2 = acceleration(world, w2)
    w3 = plus(w, h / 2, a2)
    a3 = acceleration(world, w3)
    w4 = plus(w, h, a3)
    a4 = acceleration(world, w4)
    k1 = derivative(q, w)
    k2 = derivative(plus(q, h / 2, k1), w2)
    k3 = derivative(plus(q, h / 2, k2), w3)
    k4 = derivative(plus(q, h, k3), w4)
    return unit(plus(q, h / 6, k1 + 2 * k2 + 2 * k3 + k4)), plus(w, h / 6, a1 + 2 * a2 + 2 * a3 + a4)


@compiled
def rk4_rate_before(world, q, w, h):
    return turn(q, h, w), rk4(world, q, w, h)[1]


@compiled
def rk4_rate_after(world, q, w, h):
    after = rk4(world, q, w, h)[1]
    return turn(q, h, after), after


@compiled
def rk4_derivative_after(world, q, w, h):
    """As engines write it: q += h/2 q w, and then the norm."""
    after = rk4(world, q, w, h)[1]
    return unit(plus(q, h, derivative(q, after))), after


@compiled
def stepped(stepper, world, q, w, h, attitudes, rates, factor, size):
    """Steps into two arrays; with a size, the norm of the momentum is held at it."""
    for n in range(len(rates)):
        q, w = stepper(world, q, w, h)
        if factor != 1.0:
            w = plus(0 * w, factor, w)
        if size > 0.0:
            p = times(world[0], w)
            w = plus(0 * w, size / np.sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]), w)
        attitudes[n] = q
        rates[n] = w


RIGHT: Final[dict[str, Any]] = {
    "explicit Euler": explicit_euler,
    "semi-implicit Euler": semi_implicit_euler,
    "implicit Euler": implicit_euler,
    "Lie-Euler": lie_euler,
    "explicit midpoint": explicit_midpoint,
    "implicit midpoint": implicit_midpoint,
    "Newmark": newmark,
    "RK4": rk4,
}
ONE_SIDED: Final[dict[str, Any]] = {
    "RK4, rate before": rk4_rate_before,
    "RK4, rate after": rk4_rate_after,
    "RK4, derivative of the rate after": rk4_derivative_after,
}
STEPPERS: Final = RIGHT | ONE_SIDED


def _inertias(case: EngineCase) -> dict[str, Array]:
    w, x, y, z = case.inertial_frame_wxyz
    P = quaternion.to_matrix(np.array([x, y, z, w]))
    R = quaternion.to_matrix(case.attitude_xyzw)
    diagonal = np.diag(np.diag(case.inertia))
    return {
        "moments along the body's axes": np.diag(case.principal_moments),
        "moments in descending order": np.diag(case.principal_moments[::-1]),
        "frame inverted": P.T @ np.diag(case.principal_moments) @ P,
        "products left out": diagonal,
        "products negated": 2 * diagonal - case.inertia,
        "inertia in world axes": R.T @ case.inertia @ R,
    }


def simulate(case: EngineCase, step: float, *, stepper: str, mistake: str = "", kind: str = "float64") -> Answer:
    """An integrator, right or with a mistake."""
    M = _inertias(case).get(mistake, case.inertia).astype(kind)
    gyroscopic = 0.0 if mistake.startswith("no gyroscopic") else -1.0 if mistake.startswith("gyroscopic") else 1.0
    damping = {"damping": DAMPING, "negative damping": -DAMPING}.get(mistake, 0.0) / case.period
    factor = 1.0 - DAMPING_OF_A_STEP * (mistake == "damping at each step")
    size = float(np.linalg.norm(case.inertia @ case.body_rate)) * (mistake == "momentum clamped")
    start = case.body_rate
    if mistake in ("body rate given as world rate", "world rates taken and returned"):
        start = quaternion.rotate(quaternion.conjugate(case.attitude_xyzw), start)
    if mistake == "world rate given as body rate":
        start = case.world_rate
    count = round(case.duration / step)
    attitudes, rates = np.empty((count, 4), kind), np.empty((count, 3), kind)
    world = (M, np.linalg.inv(M), gyroscopic, damping)
    with np.errstate(all="ignore"):
        stepped(
            STEPPERS[stepper],
            world,
            case.attitude_xyzw.astype(kind),
            start.astype(kind),
            step,
            attitudes,
            rates,
            factor,
            size,
        )
        if "returned" in mistake:
            rates = quaternion.rotate(attitudes, rates)
    return step * np.arange(1, count + 1), attitudes, rates


def expected(stepper: str, mistake: str, kind: str = "float64") -> set[str]:
    """Codes that an integrator with a mistake should be given.

    In single precision round-off hides how a clamped momentum moves the energy of the explicit midpoint rule.
    """
    hidden = mistake == "momentum clamped" and stepper not in EXPLICIT[: 3 if kind == "float64" else 2]
    return {"attitude_order"} if stepper in ONE_SIDED else {MISTAKES[mistake]} - {""} if not hidden else set()


def engine(stepper: str, mistake: str = "", kind: str = "float64") -> Callable[[EngineCase, float], Answer]:
    """An integrator as `judge` runs it."""
    return partial(simulate, stepper=stepper, mistake=mistake, kind=kind)


def exact(case: EngineCase, step: float) -> Answer:
    """An engine without any error."""
    t_s = step * np.arange(1, round(case.duration / step) + 1)
    truth = case.truth(t_s)
    return t_s, truth.attitude_xyzw, truth.body_rate
