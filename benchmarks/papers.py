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
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation
from scipy.special import ellipkm1

from lie_rigid_body import ClosedForm, RigidBody, State, describe
from lie_rigid_body.groups import SO, Lagrangian
from lie_rigid_body.lie import quaternion


@dataclass(frozen=True)
class Published:
    """A number of a paper.

    Attributes
    ----------
    name, source : str
    number : float
    tolerance : float
        Half a unit of its last digit, the error that the paper gives, or what its rounded inputs allow.
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
    motion = describe(body, State([0, 0, 0, 1], np.radians([-98.5, 14.5, 33.7]) / 86400))
    assert motion.period is not None
    return motion.period / 86400


def toutatis_precession() -> float:
    body = RigidBody([1.0, 3.0836, 3.235])
    motion = describe(body, State([0, 0, 0, 1], np.radians([-98.5, 14.5, 33.7]) / 86400))
    assert motion.precession_rate is not None
    return 2 * math.pi / motion.precession_rate / 86400


def toutatis_long_axis() -> float:
    """Angle between the long axis after 23 days, on 2 December 1992, and where radar saw it that day, degrees."""
    start = Rotation.from_euler("ZXZ", [145.498, 65.865, 241.524], degrees=True)
    rate = np.radians([14.51, 33.529, -98.709]) / 86400
    elapsed_s = 23 * 86400 + 3 * 3600 + 50 * 60 + 13  # since 1992-11-09 17:49:47
    motion = ClosedForm(RigidBody([3.0836, 3.235, 1.0]), State(start.as_quat(), rate))
    found = Rotation.from_quat(motion.at(np.array([elapsed_s * 10**9])).attitude_xyzw[0])
    seen = Rotation.from_euler("ZXZ", [122.2, 86.5, 107.0], degrees=True)
    long_axis = [0.0, 0.0, 1.0]
    return math.degrees(math.acos(found.apply(long_axis) @ seen.apply(long_axis)))


def apophis() -> float:
    """Energy over that of the slowest rotation of the same momentum, for which the two periods have their ratio."""
    moments = np.array([0.64, 0.97, 1.0])

    def rate(tilt: float) -> list[float]:
        return [0.0, math.sin(tilt) / moments[1], math.cos(tilt) / moments[2]]

    def periods(tilt: float) -> float:
        motion = describe(RigidBody(moments), State([0, 0, 0, 1], rate(tilt)))
        assert motion.period is not None
        assert motion.precession_rate is not None
        return motion.period * motion.precession_rate / (2 * math.pi)

    tilt = brentq(lambda each: periods(each) - 264.178 / 27.38547, 0.1, 0.8)
    return float(np.square(rate(tilt)) @ moments * moments[2])  # the momentum is 1


def earth() -> float:
    # (C − B)/A, (B − A)/C and (C − A)/B tell the moments but for a factor
    alpha, gamma = 0.00327353, 0.00002196
    A = 1.0
    C = A * (1 + alpha) / (1 - gamma)
    B = C - alpha * A
    day = 2 * math.pi  # a sidereal day in units of 1/ω
    motion = describe(RigidBody([A, B, C]), State([0, 0, 0, 1], [1e-6, 0.0, 1.0]))
    assert motion.period is not None
    return motion.period / day


def plate() -> float:
    motion = describe(RigidBody([1.0, 1.0, 2.0]), State([0, 0, 0, 1], [1e-4, 0.0, 1.0]))
    assert motion.precession_rate is not None
    return motion.precession_rate / 1.0


def racket() -> float:
    """Twist about the handle after one turn of the handle, thrown 10 % beside the intermediate axis, half turns."""
    body = RigidBody([0.00121, 0.01638, 0.01748])
    t_s = np.linspace(0.0, 2.0, 20001)
    states = ClosedForm(body, State([0, 0, 0, 1], [0.0, 6.2, 0.62])).at(np.round(t_s * 1e9).astype(np.int64))
    handle = quaternion.rotate(states.attitude_xyzw, np.array([1.0, 0.0, 0.0]))
    turned = np.unwrap(np.arctan2(-handle[:, 2], handle[:, 0]))
    caught = int(np.argmax(np.abs(turned) >= 2 * math.pi))
    face = quaternion.rotate(states.attitude_xyzw[caught], np.array([0.0, 0.0, 1.0]))
    return math.acos(face[2]) / math.pi


def landau() -> float:
    """Period of five bodies by `describe` over T = 4K √(I₁I₂I₃/((I₃−I₂)(M²−2EI₁))), the ratio farthest from 1."""
    bodies = (
        ((1.0, 2.0, 2.5), (0.1, 0.4, 1.0)),
        ((2.0, 3.0, 4.0), (1.0, 1.0, 3.0)),
        ((1.0, 1.5, 2.0), (0.2, 0.1, 1.0)),
        ((3.0, 4.0, 6.0), (0.0, 1.0, 2.0)),
        ((1.0, 5.0, 5.5), (0.3, 0.2, 1.0)),
    )
    ratios = []
    for moments, rate in bodies:
        I1, I2, I3 = moments
        w = np.array(rate)
        twice_energy, squared = float(w * w @ moments), float((w * moments) @ (w * moments))
        assert squared > twice_energy * I2
        k2 = (I2 - I1) * (twice_energy * I3 - squared) / ((I3 - I2) * (squared - twice_energy * I1))
        period = 4 * float(ellipkm1(1 - k2)) * math.sqrt(I1 * I2 * I3 / ((I3 - I2) * (squared - twice_energy * I1)))
        found = describe(RigidBody(moments), State([0, 0, 0, 1], w)).period
        assert found is not None
        ratios.append(found / period)
    return max(ratios, key=lambda ratio: abs(ratio - 1))


def frb_quaternion() -> float:
    """First component of the attitude's quaternion after 0.1 s."""
    moments = np.array([1.0, 1.6487857827119290, 1.9720127096641928])
    momentum = np.array([-0.709894965287627, -0.685144717153487, 0.163174308075589])
    motion = ClosedForm(RigidBody(moments), State([0, 0, 0, 1], momentum / moments))
    return float(motion.at(np.array([100_000_000])).attitude_xyzw[0, 0])


def frb_satellite() -> float:
    """First component of the momentum after 10 s, for moments that no mass has."""
    moments = np.array([1.0, 1.012686988782515, 3.306237422473038])
    momentum = np.array([-0.609860759302936, 0.761660947972381, 0.218957654801698])
    top = Lagrangian(SO(3), np.diag(moments))
    found = solve_ivp(
        lambda _, w: top.acceleration(w), (0.0, 10.0), momentum / moments, "DOP853", rtol=3e-14, atol=1e-15
    )
    return float(found.y[0, -1] * moments[0])


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
TOUTATIS_ATTITUDE = (
    "Euler angles that radar saw on 2 December 1992, of Y. Takahashi, M. W. Busch, D. J. Scheeres (2013), and the "
    "angle between, for e1, as in euler_solver_test.cpp of Principia"
)
APOPHIS = (
    "E/E₀ = 1.024 ± 0.013: P. Pravec et al., Icarus 233 (2014) 48, abstract at doczz.net/doc/4111739. Periods 264.178 "
    "and 27.38547 h, moments 0.64, 0.97, 1: H.-J. Lee et al., A&A 661 (2022) L3, abstract of arXiv 2204.02540"
)
FRB = "E. Celledoni, A. Zanna, ACM Trans. Math. Softw. 37 (2010) 23, 0903/ of github.com/ACM-TOMS/CALGO: "
WOLFRAM = (
    "moments and start of the rigid body of E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, as the "
    "problem RigidBody of Wolfram's NDSolve has them; the formula of L. D. Landau, E. M. Lifshitz, Mechanics, §37"
)
LANDAU = "L. D. Landau, E. M. Lifshitz, Mechanics, §37"
PUBLISHED = (
    Published("Toutatis, rotation about the long axis", TOUTATIS, 5.38, 0.03, "d", toutatis_spin),
    Published("Toutatis, precession of the long axis", TOUTATIS, 7.40, 0.03, "d", toutatis_precession),
    Published("Toutatis, long axis after 23 days, from radar's", TOUTATIS_ATTITUDE, 7.9, 0.05, "°", toutatis_long_axis),
    Published("Apophis, energy over the least one of its momentum", APOPHIS, 1.024, 0.013, "", apophis),
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
        0.15,  # a half twist almost always, within 27°
        "",
        racket,
    ),
    Published("period over the formula's, five bodies", LANDAU, 1.0, 1e-12, "", landau),
    Published("period over the formula's, moments 2, 1, 2/3", WOLFRAM, 1.0, 1e-9, "", impossible),
    Published(
        "FRB, quaternion after 0.1 s", f"{FRB}out_example2.dat", -0.035456085277494165, 2e-15, "", frb_quaternion
    ),
    Published(
        "FRB, momentum after 10 s, moments that no mass has",
        f"{FRB}out_example3.dat",
        -0.7243786338874610,
        1e-12,
        "",
        frb_satellite,
    ),
)


def main() -> None:
    """Print each number with its lines."""
    for each in PUBLISHED:
        ours = each.ours()
        digits = 2 - math.floor(math.log10(each.tolerance))
        published = f"published {each.number!r} {each.unit}".rstrip()
        differs = f"{ours - each.number:+.1e}, where {each.tolerance:g} is allowed"
        print(f"{each.name}: {published}, ours {ours:.{digits}f}, {differs}")
        print(f"  {each.source}\n")
        print("\n".join(f"    {line}" for line in inspect.getsource(each.ours).splitlines()), "\n")


if __name__ == "__main__":
    main()
