"""Result of an estimator: attitudes, and if it has them covariances and gyro biases."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import Any, Final

import numpy as np

from lie_rigid_body.evaluation.arguments import read_stamps, real_numbers, shape_remedy
from lie_rigid_body.evaluation.consistency import require_axes, rotation_block
from lie_rigid_body.foundation.arrays import Array, Booleans
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.wording import call_repr

BIAS_SUFFIX: Final = "/gyro_bias"
"""End of the name of the topic of estimated biases, behind that of the attitudes."""


@dataclass(frozen=True, eq=False)
class Estimate:
    """Attitudes that an estimator returns, with its stamps, covariances and biases where it has them; checked at once.

    Parameters
    ----------
    attitude_xyzw : array_like, shape (N, 4)
        World-from-body, scalar last.
    t_ns : array_like of int, shape (N,), optional
        Stamps, ns; by default those of the IMU, or of the truth.
    covariance : array_like, shape (N, 3, 3), (N, 6, 6), (3, 3) or (6, 6), optional
        Covariance of small rotations, or of poses, rad². A single one is that of every sample.
    covariance_axes : str, optional
        ``"world"`` or ``"body"``: the axes that the rotations are about.
    gyro_bias : array_like, shape (N, 3) or (3,), optional
        Biases of the gyro, rad/s.
    gyro_bias_covariance : array_like, shape (N, 3, 3) or (3, 3), optional
        Their covariance, rad²/s².

    Raises
    ------
    InputError
        If something has another shape, is no number, or the stamps are no rising integers.
    """

    attitude_xyzw: Any
    t_ns: Any = None
    covariance: Any = None
    covariance_axes: str = "world"
    gyro_bias: Any = None
    gyro_bias_covariance: Any = None

    def __post_init__(self) -> None:
        attitude = real_numbers("estimate", self.attitude_xyzw, "(N, 4)")
        if attitude.ndim != 2 or attitude.shape[1] != 4:
            raise InputError(f"estimate: shape {attitude.shape} is not (N, 4): {shape_remedy(attitude.shape, (4,))}")
        read: dict[str, Any] = {"attitude_xyzw": attitude}
        if self.t_ns is not None:
            read["t_ns"] = read_stamps("estimate", self.t_ns)
            if len(read["t_ns"]) != len(attitude):
                raise InputError(
                    f"estimate: attitudes of shape {attitude.shape} for {len(read['t_ns'])} stamps: give a row for "
                    "each reading of the IMU, or stamps and attitudes"
                )
        for name, *sizes in (("covariance", (3, 3), (6, 6)), ("gyro_bias_covariance", (3, 3)), ("gyro_bias", (3,))):
            if getattr(self, name) is not None:
                wanted = f"({len(attitude)}, {', '.join(map(str, sizes[0]))})"
                array = real_numbers(name, getattr(self, name), wanted)
                size = array.shape[-len(sizes[0]) :]
                if size not in sizes or array.shape not in (size, (len(attitude), *size)):
                    raise InputError(f"{name}: shape {array.shape} is not {wanted}: give a row for each stamp")
                read[name] = np.broadcast_to(array, (len(attitude), *size))
        require_axes(self.covariance_axes)
        vars(self).update(read)

    @classmethod
    def of(cls, result: object, **beside: object) -> Estimate:
        """Read what an estimator returned: an estimate, attitudes, stamps and attitudes, or what has `attitude_xyzw`.

        Parameters
        ----------
        result : object
        **beside
            Other parameters of an estimate, which take the place of its own; None leaves its own.

        Raises
        ------
        InputError
            If it is none of these, with its shape.
        """
        given: dict[str, Any]
        if hasattr(result, "attitude_xyzw"):
            given = {f.name: getattr(result, f.name) for f in fields(cls) if hasattr(result, f.name)}
        elif isinstance(result, tuple) and len(result) == 2:
            given = {"t_ns": result[0], "attitude_xyzw": result[1]}
        else:
            given = {"attitude_xyzw": result}
        return cls(**{**given, **{name: value for name, value in beside.items() if value is not None}})

    def rotation_covariance(self) -> Array:
        """Covariance of small rotations at each attitude, shape (N, 3, 3), rad².

        Raises
        ------
        InputError
            If a number is not finite, or it is not known.
        """
        return rotation_block(self.covariance)

    def __len__(self) -> int:
        return len(self.attitude_xyzw)

    def __getitem__(self, rows: slice | Booleans) -> Estimate:
        arrays: dict[str, Any] = {name: each for name, each in vars(self).items() if isinstance(each, np.ndarray)}
        return replace(self, **{name: each[rows] for name, each in arrays.items()})

    def __repr__(self) -> str:
        return call_repr(self, {name: value for name, value in vars(self).items() if value is not None})
