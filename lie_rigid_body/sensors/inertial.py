"""True quantities that an IMU measures: the mean rate over the interval between two samples, and the specific force."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.errors import InputError
from lie_rigid_body.lie import quaternion, so3
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.mechanics.inertia import apply_tensor
from lie_rigid_body.parameters import Vector
from lie_rigid_body.sensors.signal import Conditioning, Signal

_PER_RATE: Final = math.sqrt(2.0) + 2.0
"""Change of the acceleration of a point per change of the body rate, in units of the rate and of the lever arm."""
_YZX: Final = np.array([1, 2, 0])
_ZXY: Final = np.array([2, 0, 1])


class IntegratedRate:
    """The constant rate that takes the attitude of one sample to the attitude of the next.

    ``log(R_(j-1)ᵀ R_j) / (t_j − t_(j-1))``, so that the product of the ``exp(ω_j (t_j − t_(j-1)))`` is the rotation of
    the truth, with no error of integration. The logarithm takes the shorter way round: between two samples the body
    has to turn by less than π.

    Parameters
    ----------
    before_ns : int
        Time of the state one interval before the first sample, ns.
    before : State
        The state at that time, of one instant.
    """

    def __init__(self, before_ns: int, before: State) -> None:
        self._times = np.array([before_ns], dtype=np.int64)
        self._attitudes = before.attitude_xyzw.reshape(1, 4)

    def over(self, stamps_ns: Integers, states: State) -> Array:
        """The rates of the next samples.

        Parameters
        ----------
        stamps_ns : ndarray of int64, shape (N,)
        states : State
            Of N instants.

        Returns
        -------
        ndarray, shape (N, 3)
            rad/s.

        Raises
        ------
        InputError
            If a stamp is not later than the one before.
        """
        times = np.concatenate([self._times, stamps_ns])
        attitudes = np.concatenate([self._attitudes, states.attitude_xyzw])
        intervals = np.diff(times)
        if len(intervals) and intervals.min() <= 0:
            worst = int(np.argmin(intervals))
            raise InputError(
                f"stamps_ns: {times[worst + 1]} follows {times[worst]}: an integrated rate needs stamps that rise, "
                "the first one above before_ns"
            )
        self._times, self._attitudes = times[-1:], attitudes[-1:]
        turns = quaternion.log(quaternion.multiply(quaternion.conjugate(attitudes[:-1]), attitudes[1:]))
        return np.asarray(turns / (intervals / 1e9)[:, np.newaxis])


class SpecificForce:
    """Acceleration less gravitation at a point that moves with the body: ω̇×r + ω×(ω×r) + Aᵀ(0, 0, g).

    The first two terms are the acceleration of the point about the mass centre. The last one is what holds the mass
    centre: nothing in free fall; on a frictionless pivot there, the weight upwards, which makes no torque.

    Parameters
    ----------
    body : RigidBody
    lever_arm : tuple of float, length 3
        r, from the mass centre to the point in the body frame, m.
    support : float
        g with the pivot, 0 in free fall, m/s², along z of the world frame.
    """

    def __init__(self, body: RigidBody, lever_arm: Vector, support: float) -> None:
        moments = body.principal_moments
        # (I₂ − I₃)/I₁, each of size 1 at most, as the moments obey the triangle inequality
        self._euler = (moments[_YZX] - moments[_ZXY]) / moments
        self._to_principal = body.principal_axes.T
        self._across = -so3.hat(lever_arm)
        self._principal_across = self._across @ body.principal_axes
        self._has_lever_arm, self._arm = any(lever_arm), float(so3.norm(np.array(lever_arm)))
        self._support = support

    def signal(self, states: State) -> Signal:
        """The specific force in the body frame, m/s², shape (N, 3): exactly 0 at the mass centre in free fall.

        The quotients of moments in Euler's equations are of size 1 at most. So an error δω of the rate changes ω̇×r by
        at most √2 ‖ω‖‖r‖ δω, and ω×(ω×r) by twice ‖ω‖‖r‖ δω; one of the attitude turns the support.

        Parameters
        ----------
        states : State
            Of N instants.
        """
        rate = states.body_rate
        force = self._of_rotation(rate) if self._has_lever_arm else np.zeros_like(rate)
        if self._support:
            # the world's z axis in the body frame: the last row of the rotation matrix
            x, y, z, w = states.attitude_xyzw.T
            up = 2.0 * np.stack([x * z - y * w, y * z + x * w, 0.5 - (x * x + y * y)], axis=-1)
            force = force + self._support * up

        def conditioning() -> Conditioning:
            speed = so3.norm(rate)
            size = 3.0 * speed * speed * self._arm + self._support
            return Conditioning.of(size, self._support, _PER_RATE * speed * self._arm)

        return Signal(force, condition=conditioning)

    def _of_rotation(self, rate: Array) -> Array:
        """Acceleration of the point relative to the mass centre, body frame, m/s²: ω̇×r + ω×(ω×r)."""
        # ω̇ in principal axes: ω̇₁ = (I₂ − I₃)/I₁ ω₂ω₃ and cyclically (Landau & Lifshitz §36, 36.5)
        principal = apply_tensor(self._to_principal, rate)
        turning = self._euler * principal.take(_YZX, axis=-1) * principal.take(_ZXY, axis=-1)
        tangential = apply_tensor(self._principal_across, turning)
        return tangential + _cross(rate, apply_tensor(self._across, rate))


def _cross(a: Array, b: Array) -> Array:
    return a.take(_YZX, axis=-1) * b.take(_ZXY, axis=-1) - a.take(_ZXY, axis=-1) * b.take(_YZX, axis=-1)
