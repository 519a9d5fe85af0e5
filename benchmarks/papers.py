"""Published numbers of free rotations beside ours: ``make papers``, or ``python benchmarks/papers.py``.

Each has its source, which was looked up, and the few lines that make the number. What could not be looked up is not
here: docs/explanation/papers.md says what that is.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.special import ellipkm1

from lie_rigid_body import ClosedForm, RigidBody, State, describe
from lie_rigid_body.groups import SO, Lagrangian
from lie_rigid_body.lie import quaternion

DAY = 86400.0
IDENTITY = [0.0, 0.0, 0.0, 1.0]


BODIES = (
    ((1.0, 2.0, 2.5), (0.1, 0.4, 1.0)),
    ((2.0, 3.0, 4.0), (1.0, 1.0, 3.0)),
    ((1.0, 1.5, 2.0), (0.2, 0.1, 1.0)),
    ((3.0, 4.0, 6.0), (0.0, 1.0, 2.0)),
    ((1.0, 5.0, 5.5), (0.3, 0.2, 1.0)),
)


@dataclass(frozen=True)
class Published:
    """A number of a paper.

    Attributes
    ----------
    name, source : str
    number : float
    tolerance : float
        Half a unit of its last digit, or the error that the paper gives.
    unit : str
    ours : callable
        Without arguments.
    """

    name: str
    source: str
    number: float
    tolerance: float
    unit: str
    ours: Callable[[], float]


def toutatis_spin() -> float:
    body = RigidBody([1.0, 3.0836, 3.235])
    motion = describe(body, State(IDENTITY, np.radians([-98.5, 14.5, 33.7]) / DAY))
    assert motion.period is not None
    return motion.period / DAY


def toutatis_precession() -> float:
    body = RigidBody([1.0, 3.0836, 3.235])
    motion = describe(body, State(IDENTITY, np.radians([-98.5, 14.5, 33.7]) / DAY))
    assert motion.precession_rate is not None
    return 2 * math.pi / motion.precession_rate / DAY


def earth() -> float:
    # (C − B)/A, (B − A)/C and (C − A)/B tell the moments but for a factor
    alpha, gamma = 0.00327353, 0.00002196
    A = 1.0
    C = A * (1 + alpha) / (1 - gamma)
    B = C - alpha * A
    day = 2 * math.pi  # a sidereal day in units of 1/ω
    motion = describe(RigidBody([A, B, C]), State(IDENTITY, [1e-6, 0.0, 1.0]))
    assert motion.period is not None
    return motion.period / day


def plate() -> float:
    motion = describe(RigidBody([1.0, 1.0, 2.0]), State(IDENTITY, [1e-4, 0.0, 1.0]))
    assert motion.precession_rate is not None
    return motion.precession_rate / 1.0


def racket() -> float:
    """Twist about the handle after one turn of the handle, thrown 10 % beside the intermediate axis, half turns."""
    body = RigidBody([0.00121, 0.01638, 0.01748])
    t_s = np.linspace(0.0, 2.0, 20001)
    states = ClosedForm(body, State(IDENTITY, [0.0, 6.2, 0.62])).at(np.round(t_s * 1e9).astype(np.int64))
    handle = quaternion.rotate(states.attitude_xyzw, np.array([1.0, 0.0, 0.0]))
    turned = np.unwrap(np.arctan2(-handle[:, 2], handle[:, 0]))
    caught = int(np.argmax(np.abs(turned) >= 2 * math.pi))
    face = quaternion.rotate(states.attitude_xyzw[caught], np.array([0.0, 0.0, 1.0]))
    return round(math.acos(face[2]) / math.pi)


def landau() -> float:
    """Period of five bodies by `describe` over T = 4K √(I₁I₂I₃/((I₃−I₂)(M²−2EI₁))), the ratio farthest from 1."""
    ratios = []
    for moments, rate in BODIES:
        I1, I2, I3 = moments
        w = np.array(rate)
        twice_energy, squared = float(w * w @ moments), float((w * moments) @ (w * moments))
        assert squared > twice_energy * I2
        k2 = (I2 - I1) * (twice_energy * I3 - squared) / ((I3 - I2) * (squared - twice_energy * I1))
        period = 4 * float(ellipkm1(1 - k2)) * math.sqrt(I1 * I2 * I3 / ((I3 - I2) * (squared - twice_energy * I1)))
        found = describe(RigidBody(moments), State(IDENTITY, w)).period
        assert found is not None
        ratios.append(found / period)
    return max(ratios, key=lambda ratio: abs(ratio - 1))


def impossible() -> float:
    """Period of a body that no mass has, by Euler's equations of the group, over that of the formula."""
    top = Lagrangian(SO(3), np.diag([2.0, 1.0, 2 / 3]))
    start = np.array([math.cos(1.1) / 2, 0.0, math.sin(1.1) / (2 / 3)])
    middle = lambda _, w: w[1]  # noqa: E731
    middle.direction = 1 if top.acceleration(start)[1] > 0 else -1  # type: ignore[attr-defined]
    found = solve_ivp(
        lambda _, w: top.acceleration(w), (0.0, 30.0), start, "DOP853", events=middle, rtol=1e-13, atol=1e-13
    )
    crossings = found.t_events[0]
    I1, I2, I3 = 2 / 3, 1.0, 2.0
    twice_energy = float(start * start @ np.array([2.0, 1.0, 2 / 3]))
    if twice_energy * I2 > 1.0:
        I1, I3 = I3, I1
    k2 = (I2 - I1) * (twice_energy * I3 - 1.0) / ((I3 - I2) * (1.0 - twice_energy * I1))
    period = 4 * float(ellipkm1(1 - k2)) * math.sqrt(I1 * I2 * I3 / ((I3 - I2) * (1.0 - twice_energy * I1)))
    return float(crossings[-1] - crossings[-2]) / period


TOUTATIS = (
    "Y. Zhao, S. Hu, J. Ji, IAU Symp. 318 (2016) 156, arXiv 1511.04357; moments and rates of Takahashi et al. 2013, "
    "as in euler_solver_test.cpp of Principia"
)
LANDAU = "L. D. Landau, E. M. Lifshitz, Mechanics, §37"
PUBLISHED = (
    Published("Toutatis, rotation about the long axis", TOUTATIS, 5.38, 0.03, "d", toutatis_spin),
    Published("Toutatis, precession of the long axis", TOUTATIS, 7.40, 0.03, "d", toutatis_precession),
    Published(
        "Earth as a rigid body, Euler's free nutation",
        "moments (C−B)/A = 0.00327353, (B−A)/C = 0.00002196; O. Portilho, arXiv 0809.4506: 305 d",
        305.0,
        1.0,
        "sidereal d",
        earth,
    ),
    Published(
        "Feynman's plate, wobble over spin",
        "S. M. Blinder, Wolfram Demonstrations (2011); M. Levi, SIAM News: 2, where Feynman wrote one half",
        2.0,
        1e-6,
        "",
        plate,
    ),
    Published(
        "tennis racket, half twists after one turn",
        "M. S. Ashbaugh, C. C. Chicone, R. H. Cushman, J. Dyn. Diff. Eq. 3 (1991) 67",
        1.0,
        0.0,
        "",
        racket,
    ),
    Published("period over the formula's, five bodies", LANDAU, 1.0, 1e-12, "", landau),
    Published("period over the formula's, moments 2, 1, 2/3", LANDAU, 1.0, 1e-9, "", impossible),
)


def main() -> None:
    """Print each number with its lines."""
    for each in PUBLISHED:
        ours = each.ours()
        numbers = f"published {each.number:g} ± {each.tolerance:g} {each.unit}, ours {ours:.9g}".replace(" ,", ",")
        print(f"{each.name}: {numbers}, {ours - each.number:+.1e}")
        print(f"  {each.source}\n")
        print("\n".join(f"    {line}" for line in inspect.getsource(each.ours).splitlines()), "\n")


if __name__ == "__main__":
    main()
