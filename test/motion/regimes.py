"""Random motions of every regime: what the formulas of the exact solution depend on, near and at each of its edges."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.random import Generator

from lie_rigid_body import RigidBody, State
from lie_rigid_body.lie import quaternion

LONGEST_NS = 9 * 10**18


class Motion(NamedTuple):
    """Inertia, attitude and body rate at the start, as both the package and a proof take them."""

    inertia: np.ndarray
    attitude_xyzw: np.ndarray
    rate: np.ndarray

    @property
    def body(self) -> RigidBody:
        return RigidBody(self.inertia)

    @property
    def start(self) -> State:
        return State(self.attitude_xyzw, self.rate)

    def stamp(self, radians: float) -> int:
        """When the body has turned about so far, ns, within 285 years."""
        speed = float(np.max(np.abs(self.rate))) or 1.0
        return int(max(-LONGEST_NS, min(1e9 * radians / speed, LONGEST_NS)))


def moments(rng: Generator) -> np.ndarray:
    a, b, c = rng.uniform(0.05, 1.0, 3)
    return np.sort([b + c, a + c, a + b])


def small(rng: Generator, low: float, high: float) -> float:
    return float(10.0 ** rng.uniform(low, high) * rng.choice([-1, 1]))


def generic(rng: Generator) -> tuple[np.ndarray, np.ndarray]:
    return rng.permutation(moments(rng)), rng.normal(size=3)


def near_separatrix(rng: Generator) -> tuple[np.ndarray, np.ndarray]:
    inertia = moments(rng)
    e, p = 1.0 / inertia, rng.normal(size=3)
    p[2] = np.sqrt((e[0] - e[1]) / (e[1] - e[2])) * p[0] * (1.0 + small(rng, -16, -3))
    return inertia, p / inertia


def on_separatrix(rng: Generator) -> tuple[np.ndarray, np.ndarray]:
    """I₁(I₂−I₁)ω₁² = I₃(I₃−I₂)ω₃² with moments 3, 4 and 6."""
    size = rng.integers(1, 1000) / 512.0
    rate = [2.0 * size * rng.choice([-1, 1]), rng.normal(), size * rng.choice([-1, 1])]
    return np.array([3.0, 4.0, 6.0]) * 2.0 ** rng.integers(-5, 5), np.array(rate)


def flips(rng: Generator) -> tuple[np.ndarray, np.ndarray]:
    return moments(rng), np.array([0.0, 1.0, 0.0]) + 10.0 ** rng.uniform(-18, -2) * rng.normal(size=3)


def nearly_steady(rng: Generator) -> tuple[np.ndarray, np.ndarray]:
    rate = 10.0 ** rng.uniform(-300, -2) * rng.normal(size=3)
    rate[rng.integers(3)] += 1.0
    return moments(rng), rate


def in_a_principal_plane(rng: Generator) -> tuple[np.ndarray, np.ndarray]:
    rate = rng.permutation([0.0, 1.0, 10.0 ** rng.uniform(-200, 0)])
    return rng.permutation(moments(rng)), rate


def scaled(rng: Generator) -> tuple[np.ndarray, np.ndarray]:
    """Units of mass and of time far from one another."""
    return moments(rng) * 10.0 ** rng.uniform(-12, 12), rng.normal(size=3) * 10.0 ** rng.uniform(-12, 3)


def tiny_products(rng: Generator) -> tuple[np.ndarray, np.ndarray]:
    """Equal moments that a product of inertia of any size sets apart."""
    product = 10.0 ** rng.uniform(-100, -1)
    tensor = np.array([[1.0, product, 0.0], [product, 1.0, 0.0], [0.0, 0.0, 0.5]])
    return tensor, np.array([1.0, 0.5, rng.choice([0.2, 0.5 * np.sqrt(product)])])


def steady(rng: Generator) -> tuple[np.ndarray, np.ndarray]:
    return moments(rng), np.eye(3)[rng.integers(3)] * rng.normal()


def symmetric(rng: Generator) -> tuple[np.ndarray, np.ndarray]:
    inertia = moments(rng)
    inertia[1] = inertia[2]
    return rng.permutation(inertia), rng.normal(size=3)


def nearly_symmetric(rng: Generator) -> tuple[np.ndarray, np.ndarray]:
    inertia = moments(rng)
    inertia[1] = np.nextafter(inertia[2], 0.0) if rng.random() < 0.5 else inertia[2] * (1.0 + small(rng, -15, -5))
    return rng.permutation(inertia), rng.normal(size=3)


def nearly_spherical(rng: Generator) -> tuple[np.ndarray, np.ndarray]:
    return 1.0 + 2.0**-50 * rng.permutation(3), rng.normal(size=3)


def flat(rng: Generator) -> tuple[np.ndarray, np.ndarray]:
    a, b, _ = rng.uniform(0.2, 1.0, 3)
    return np.array([a, b, a + b]), rng.normal(size=3)


def tensor(rng: Generator) -> tuple[np.ndarray, np.ndarray]:
    return turned(moments(rng), rng), rng.normal(size=3)


def nearly_symmetric_tensor(rng: Generator) -> tuple[np.ndarray, np.ndarray]:
    return turned(np.array([0.5, 0.5 * (1.0 + 10.0 ** rng.uniform(-17, -3)), 0.8]), rng), rng.normal(size=3)


def turned(principal: np.ndarray, rng: Generator) -> np.ndarray:
    """A tensor with products of inertia."""
    axes = quaternion.to_matrix(random_attitude(rng))
    matrix = axes @ np.diag(principal) @ axes.T
    return 0.5 * (matrix + matrix.T)


def random_attitude(rng: Generator) -> np.ndarray:
    return quaternion.normalize(rng.normal(size=4))


REGIMES: dict[str, Callable[[Generator], tuple[np.ndarray, np.ndarray]]] = {
    draw.__name__: draw
    for draw in (
        *(generic, near_separatrix, on_separatrix, flips, nearly_steady, steady, symmetric, nearly_symmetric),
        *(nearly_spherical, flat, tensor, nearly_symmetric_tensor, in_a_principal_plane, scaled, tiny_products),
    )
}


def motion(regime: str, seed: int) -> Motion:
    """One random motion of a regime."""
    rng = np.random.default_rng([seed, *regime.encode()])
    inertia, rate = REGIMES[regime](rng)
    return Motion(inertia, random_attitude(rng), rate)
