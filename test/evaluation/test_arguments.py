"""What callers give is read whole, or refused in one line that names it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from lie_rigid_body import Limits, SampledTruth, attitude_error, simulate
from lie_rigid_body.evaluation.arguments import read_series, read_stamps
from lie_rigid_body.evaluation.remarks import of_series
from lie_rigid_body.foundation.errors import InputError

Q = np.tile([0.0, 0.0, 0.0, 1.0], (3, 1))


def test_a_mask_of_nothing_and_numbers_as_objects_are_read():
    np.testing.assert_array_equal(read_series("estimate", [0, 1, 2], Q.astype(object))[1], Q)
    assert read_stamps("estimate", [-(2**31) * 10**9, 2**31 * 10**9]).dtype == np.int64
    assert attitude_error(np.ma.masked_array(Q), Q).total.max() == 0.0


@pytest.mark.parametrize("kind", [np.int8, np.uint8, np.int16, np.uint64])
def test_stamps_of_any_integer_type_are_read(kind):
    truth, stamps = SampledTruth([0, 50, 100], Q), np.array([0, 25, 120], kind)
    assert truth.covers(stamps).tolist() == [True, True, False]
    assert truth.uncertainty_at(stamps) == truth.uncertainty_at(stamps.astype(np.int64))
    for found, wanted in zip(truth.states(stamps), truth.states(stamps.astype(np.int64)), strict=True):
        np.testing.assert_array_equal(found, wanted)


@pytest.mark.filterwarnings("error")
def test_a_norm_whose_square_overflows_is_remarked():
    for factor, codes in ((1e200, ["not_unit"]), (1.0009, []), (0.9989, ["not_unit"])):
        assert [
            remark.code for remark in of_series(np.arange(3), np.full(3, True), factor * Q, SampledTruth([0, 2], Q[:2]))
        ] == codes


@pytest.mark.filterwarnings("error")
def test_a_number_of_another_type_is_read_or_refused():
    limits: Any = Limits
    assert limits(np.float32(1.0)).max_rms_deg == Limits(1).max_rms_deg == 1.0
    for value in (np.timedelta64(1, "s"), np.bool_(True), "1", 10**400, np.nan, 0):
        with pytest.raises(InputError):
            limits(value)
    spans: list[Any] = [np.timedelta64(1, "s"), np.timedelta64(100, "ns"), np.array(np.timedelta64(100, "ns"))]
    for span in spans:
        with pytest.raises(InputError):
            simulate(duration=span)
    view: Any = memoryview(np.ones((2, 1, 1)))
    with pytest.raises(InputError):
        simulate(duration=0.1, inertia=view)
    with pytest.raises(InputError):
        simulate(duration=0.1, seeds=view)
