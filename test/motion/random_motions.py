"""Random bodies and starts for laws, and what becomes of a small change of a start."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from lie_rigid_body import RigidBody, State
from lie_rigid_body.lie import quaternion, vectors

COMPONENT = st.floats(-3.0, 3.0).filter(lambda x: x == 0.0 or abs(x) > 1e-3)
RATES = st.tuples(COMPONENT, COMPONENT, COMPONENT)
SECOND_MOMENTS = st.tuples(*[st.floats(0.0, 1.0)] * 3).filter(lambda d: sorted(d)[1] > 0.05)
"""Of mass along each axis: any three are those of a body, a flat one where one is 0, a rod where two are."""

TURNS = st.tuples(*[st.floats(-1.0, 1.0)] * 4).filter(lambda q: np.linalg.norm(q) > 0.1)
ANGLES = st.floats(0.01, 3.0)
"""Of the motion, rad."""

QUARTER = np.sqrt(0.5)
AXIS_TURNS = st.sampled_from(
    [
        *([0.5, 0.5, 0.5, 0.5], [0.5, 0.5, 0.5, -0.5], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]),
        *([QUARTER, 0.0, 0.0, QUARTER], [0.0, QUARTER, 0.0, QUARTER], [0.0, 0.0, -QUARTER, QUARTER]),
    ]
)
"""Rotations that only give the body axes other names and signs: in cyclic order, by half turns and by quarter turns."""


def body_of(second_moments) -> RigidBody:
    a, b, c = second_moments
    return RigidBody([b + c, a + c, a + b])


def unit(turn) -> np.ndarray:
    return quaternion.normalize(np.array(turn))


def turned_body(body: RigidBody, turn) -> tuple[RigidBody, np.ndarray]:
    """The body seen from a frame turned by this quaternion, and the matrix that takes components to that frame."""
    matrix = quaternion.to_matrix(turn)
    tensor = matrix @ body.inertia @ matrix.T
    return RigidBody(0.5 * (tensor + tensor.T)), matrix


def fastest(body: RigidBody, start: State) -> float:
    """No rate of the motion is larger, as 2H ≥ I₁|ω|²; and 1e-3 where it is at rest."""
    return max(float(np.sqrt(2.0 * body.kinetic_energy(start) / body.principal_moments[0])), 1e-3)


def growth(angle: float) -> float:
    """What a change of ω may grow by, in time t with ``angle`` = |ω|max t.

    A change by ε makes at most ε exp(Λt), as ω′ = f(ω) with |∂f/∂ω| ≤ Λ = 2|ω|max: each |Iᵢ − Iⱼ|/Iₖ is at most 1.
    It turns the attitude by no more than ∫ε exp(Λt)dt.
    """
    return float(np.exp(2.0 * angle))


def difference(found: State, expected: State) -> float:
    """The larger of the distances of quaternions, signs included, and of rates relative to the largest."""
    attitude = np.abs(found.attitude_xyzw - expected.attitude_xyzw).max()
    size = max(float(vectors.norm(expected.body_rate).max()), 1e-300)
    return float(max(attitude, np.abs(found.body_rate - expected.body_rate).max() / size))
