"""Reading an estimate: stamps and quaternions as a filter gave them, with what is wrong about them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.arrays import Array, Booleans, Integers
from lie_rigid_body.errors import InputError
from lie_rigid_body.evaluation.arguments import unmasked
from lie_rigid_body.evaluation.attitude_error import unit
from lie_rigid_body.lie import quaternion
from lie_rigid_body.wording import short_repr

GAP: Final = 2.5
"""Least distance of neighbouring stamps that is a gap, in median periods: two samples or more are missing."""
_GAP_OF_EVEN: Final = 1.5
"""Least distance that is a gap where stamps are even, so that one missing sample stands out, in median periods."""
_EVEN, _MOST_UNEVEN = 0.1, 0.1
"""Tolerances of even stamps: relative difference of a period from the median, share of periods that differ more."""

FARTHEST_NS: Final = 2**31 * 10**9
"""Largest stamp that a message can have, ns; differences of such stamps do not overflow."""

NOT_UNIT: Final = 0.002
"""Largest | |q|² − 1 | that is taken for unit norm: what remains of one written with three decimals. tf2 takes 0.01."""


@dataclass(frozen=True)
class Remark:
    """Remark on an estimate that holds whatever convention its attitudes are in.

    Attributes
    ----------
    code : str
        ``gaps``, ``not_unit``, ``stuck``, ``mixed``, ``turn_rate`` or ``turn_axes``.
    message : str
        One sentence.
    """

    code: str
    message: str

    __repr__ = short_repr


@dataclass(frozen=True)
class ReadEstimate:
    """An attitude estimate over time.

    Attributes
    ----------
    stamps_ns : ndarray of int64, shape (N,)
        Increasing.
    attitude_xyzw : ndarray, shape (N, 4)
        As given, of unit norm.
    remarks : tuple of Remark
    """

    stamps_ns: Integers
    attitude_xyzw: Array
    remarks: tuple[Remark, ...] = ()

    __repr__ = short_repr

    @classmethod
    def read(cls, stamps_ns: ArrayLike, attitude_xyzw: ArrayLike) -> ReadEstimate:
        """Read an estimate as a filter gave it.

        Of samples with the same stamp the first is kept, and they are remarked.

        Parameters
        ----------
        stamps_ns : array_like of int, shape (N,)
            Nanoseconds, never decreasing.
        attitude_xyzw : array_like, shape (N, 4)
            World-from-body, scalar last. Normalised; a norm that is far from 1 is remarked.

        Raises
        ------
        InputError
            If it is empty, stamps decrease, or a quaternion is not finite or zero.
        """
        stamps, attitude = read_stamps("estimate", stamps_ns), unit("estimate", attitude_xyzw)
        if attitude.shape != (len(stamps), 4):
            raise InputError(
                f"estimate: attitudes of shape {attitude.shape} for {len(stamps)} stamps: give a row for each stamp"
            )
        new = np.concatenate([[True], np.diff(stamps) > 0])
        found = (_doubles(stamps, new), _gaps(stamps[new]), _norms(np.asarray(attitude_xyzw, dtype=np.float64)))
        return cls(stamps[new], attitude[new], tuple(remark for remark in found if remark))


def read_stamps(name: str, stamps_ns: ArrayLike) -> Integers:
    """Read stamps as int64, never decreasing, at least one.

    Raises
    ------
    InputError
        If they are not that.
    """
    unmasked(f"{name}: stamps", stamps_ns)
    stamps = np.asarray(stamps_ns)
    if stamps.ndim != 1 or stamps.size == 0:
        raise InputError(f"{name}: stamps of shape {stamps.shape}: give a flat list of at least one")
    if stamps.dtype.kind not in "iu":
        how = {"f": ", as np.round(t_s * 1e9).astype(np.int64) of seconds", "M": ", as stamps.astype('int64') of ns"}
        raise InputError(
            f"{name}: stamps of type {stamps.dtype}: give integer nanoseconds{how.get(stamps.dtype.kind, '')}"
        )
    if max(int(stamps.max()), -int(stamps.min())) > FARTHEST_NS:
        raise InputError(
            f"{name}: stamps from {stamps.min()} to {stamps.max()}: those of ROS 2 are within 2**31 s: give nanoseconds"
        )
    stamps = stamps.astype(np.int64)
    back = np.flatnonzero(np.diff(stamps) < 0)
    if back.size:
        k = int(back[0])
        jump_s = (stamps[k] - stamps[k + 1]) / 1e9
        raise InputError(
            f"{name}: out of order in {back.size} places, first at sample {k + 1}, {jump_s:g} s before "
            "the one ahead of it: sort by stamp, or evaluate the parts before and after a reset apart"
        )
    return stamps


def in_order(stamps_ns: Integers, after_ns: int | None = None) -> Booleans:
    """Whether each stamp, ns, is before none that came earlier, and not before `after_ns`."""
    first = int(stamps_ns[0]) if after_ns is None and len(stamps_ns) else after_ns or 0
    return np.asarray(stamps_ns >= np.maximum.accumulate(np.concatenate([[first], stamps_ns]))[:-1])


def period_ns(stamps_ns: Integers) -> int:
    """Median time between stamps, ns; 0 for a single one."""
    return int(np.median(np.diff(stamps_ns))) if len(stamps_ns) > 1 else 0


def _doubles(stamps: Integers, new: Booleans) -> Remark | None:
    count = int(np.count_nonzero(~new))
    if not count:
        return None
    return Remark(
        "gaps",
        f"{count} of {len(stamps)} samples are doubles, of a stamp that another sample had before, first at "
        f"{_since(stamps, stamps[~new][0]):g} s; only the first of a stamp counts: let one publisher write the topic.",
    )


def _gaps(stamps: Integers) -> Remark | None:
    steps, period = np.diff(stamps), period_ns(stamps)
    uneven = np.count_nonzero(np.abs(steps - period) > _EVEN * period)
    gap = _GAP_OF_EVEN if uneven <= _MOST_UNEVEN * len(steps) else GAP
    wide = np.flatnonzero(steps > gap * period) if period else np.empty(0, dtype=np.int64)
    if not wide.size:
        return None
    longest = wide[np.argmax(steps[wide])]
    return Remark(
        "gaps",
        f"{wide.size} {'gap' if wide.size == 1 else 'gaps'} in the estimate, the longest of {steps[longest] / 1e9:g} s "
        f"after {_since(stamps, stamps[longest]):g} s, where samples come every {period / 1e9:g} s: "
        "what the filter did there is not in the score; look for lost messages.",
    )


def _norms(given: Array) -> Remark | None:
    norms = quaternion.norm(given)
    off = (norms < np.sqrt(1.0 - NOT_UNIT)) | (norms > np.sqrt(1.0 + NOT_UNIT))  # the square of a large norm overflows
    if not off.any():
        return None
    worst = norms[np.argmax(np.abs(norms - 1.0))]
    return Remark(
        "not_unit",
        f"{np.count_nonzero(off)} of {len(norms)} quaternions are not of unit norm, the worst has {worst:.4g}; "
        "they were divided by it here, and tf2 refuses 0.005 more or less: let the filter normalise what it publishes.",
    )


def _since(stamps: Integers, stamp: int) -> float:
    return float(stamp - stamps[0]) / 1e9
