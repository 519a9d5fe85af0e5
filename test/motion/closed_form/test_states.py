"""Rows of constants and their nesting: what is written into a row is read from the same places."""

from __future__ import annotations

from itertools import count
from typing import Any

import numpy as np
import pytest

from lie_rigid_body.motion.closed_form.attitude import (
    AttitudeConstants,
    SteadyMotion,
    attitude_constants,
)
from lie_rigid_body.motion.closed_form.jacobi import QUOTIENTS_LENGTH, ThetaQuotients, theta_quotients
from lie_rigid_body.motion.closed_form.states import (
    GeneralConstants,
    flattened,
    general_constants,
    steady_constants,
)


def numbered(shape: Any, numbers: count) -> Any:
    """A nest of this shape, 0 for a number and n for n numbers, filled with 0, 1, 2, … in order."""
    if isinstance(shape, int):
        return tuple(float(next(numbers)) for _ in range(shape)) if shape else float(next(numbers))
    return tuple(numbered(part, numbers) for part in shape)


def quotients(numbers: count) -> ThetaQuotients:
    return ThetaQuotients(*numbered((0, 4, 4, 4, 4, 4, 4), numbers))


def attitude(numbers: count) -> AttitudeConstants:
    return AttitudeConstants(*numbered((0, 2, 3, (4, 4, 4, 4), (3, 3, 3)), numbers))


def general(numbers: count) -> GeneralConstants:
    rate, start, half_turn, period, drift = numbered((2, 2, 2, 2, 0), numbers)
    return GeneralConstants(rate, start, half_turn, period, drift, quotients(numbers), attitude(numbers))


@pytest.mark.parametrize(
    ("constants", "read"),
    [
        (general(count()), general_constants),
        (SteadyMotion(*numbered((2, 4, 4, 3), count())), steady_constants),
        (quotients(count()), lambda row: theta_quotients(row, 0)),
        (attitude(count()), lambda row: attitude_constants(row, 0)),
    ],
)
def test_constants_are_read_from_the_places_where_they_are_written(constants, read):
    row = flattened(constants)
    assert row == list(range(len(row)))
    assert read(row) == constants


def test_length_in_a_row_is_that_of_the_quotients():
    assert len(flattened(quotients(count()))) == QUOTIENTS_LENGTH


def test_arrays_of_many_motions_stay_whole_in_a_row():
    row = flattened((np.zeros(3), (np.ones(3), 2.0)))
    assert [np.shape(entry) for entry in row] == [(3,), (3,), ()]
