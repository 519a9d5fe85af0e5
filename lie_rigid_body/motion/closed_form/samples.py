"""Samples in compiled code: first as columns, which a processor fills several places at a time, then as states."""

from __future__ import annotations

from typing import Any, Final, TypeAlias

from lie_rigid_body.arithmetic.numbers import Number
from lie_rigid_body.compilation import kernel

Sample: TypeAlias = tuple[Number, Number, Number, Number, Number, Number, Number]
"""x y z w and the body rate."""

COLUMNS: Final = 7
BLOCK: Final = 256
"""Samples whose columns stay in a processor's nearest cache."""

SIGNATURE: Final = "void(float64[:,:], int64[::1], int64[::1], float64[:,:,::1], float64[:,:,::1], float64[::1], int64)"
"""Of the functions that fill an ensemble's states

table : ndarray, shape (constants, B)
    Those of motions of one kind.
members : ndarray of int64, shape (B,)
    Their places in the ensemble.
t_ns : ndarray of int64, shape (N,)
attitude_xyzw, body_rate : ndarray, shapes (bodies, T, 4) and (bodies, T, 3)
    Where the states go.
columns : ndarray, shape (COLUMNS * BLOCK,)
    To work in, one column after the other: a compiler sees that they do not overlap.
first : int
    Place of the first of these times among T.
"""


@kernel
def put(columns: Any, i: int, sample: Sample) -> None:
    """Put a sample into a place of each column."""
    for k in range(COLUMNS):
        columns[k * BLOCK + i] = sample[k]


@kernel
def store(columns: Any, count: int, attitude: Any, rate: Any, first: int) -> None:
    """Store so many samples among the states of one body."""
    for i in range(count):
        for k in range(4):
            attitude[first + i, k] = columns[k * BLOCK + i]
        for k in range(3):
            rate[first + i, k] = columns[(4 + k) * BLOCK + i]
