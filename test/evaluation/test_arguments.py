"""What callers give is read whole, or refused in one line that names it."""

from __future__ import annotations

import numpy as np
import pytest

from lie_rigid_body import InputError, attitude_error
from lie_rigid_body.evaluation import Limits, nees
from lie_rigid_body.evaluation.arguments import read_series, read_stamps
from lie_rigid_body.evaluation.remarks import of_series

Q = np.tile([0.0, 0.0, 0.0, 1.0], (3, 1))


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -1.0, 0.0, "1deg", True, [1.0], 10**400])
def test_a_limit_that_no_error_or_every_error_breaks_is_refused(value):
    for given in ({"max_rms_deg": value}, {"max_after": ((1.0, value),)}):
        said = "0 is not above 0: give" if value in (-1.0, 0.0) else "is not a finite number of degrees above 0: give"
        with pytest.raises(InputError, match=said) as error:
            Limits(**given)
        assert len(str(error.value)) <= 200


@pytest.mark.parametrize("max_after", [5, (5,), ((-1.0, 1.0),), ((float("nan"), 1.0),)])
def test_a_time_of_a_limit_is_refused_as_well(max_after):
    with pytest.raises(InputError, match="max_after"):
        Limits(max_after=max_after)


@pytest.mark.parametrize("text", ["0deg", "0s:0deg", 5, None])
def test_a_text_that_is_no_limit_is_refused(text):
    with pytest.raises(InputError, match="give"):
        Limits.parse(max_after=text) if text != "0deg" else Limits.parse(text)


def test_an_imaginary_part_and_a_mask_are_not_dropped():
    masked = np.ma.masked_array(Q, mask=Q == 0.0)
    with pytest.raises(InputError, match="complex"):
        attitude_error(Q + 1j, Q)
    with pytest.raises(InputError, match="masked"):
        attitude_error(Q, masked)
    with pytest.raises(InputError, match="complex"):
        nees(np.zeros((3, 3)), np.eye(3) * 1j)
    with pytest.raises(InputError, match="masked"):
        read_stamps("estimate", np.ma.masked_array([0, 1, 2], mask=[False, True, False]))
    assert attitude_error(np.ma.masked_array(Q), Q).total.max() == 0.0


@pytest.mark.filterwarnings("error")
def test_a_norm_whose_square_overflows_is_remarked():
    for factor, codes in ((1e200, ["not_unit"]), (1.0009, []), (0.9989, ["not_unit"])):
        assert [remark.code for remark in of_series(np.arange(3), np.full(3, True), factor * Q)] == codes


@pytest.mark.parametrize(
    "given",
    [Q.astype(str), Q.astype(bool), Q.astype(str).astype(object), [[None] * 4] * 3, [[1, 2], [3]], {"q": Q}, object()],
)
def test_what_numpy_would_make_numbers_of_is_refused(given):
    with pytest.raises(InputError, match="estimate: not numbers: give an array of shape") as error:
        read_series("estimate", [0, 1, 2], given)
    assert len(str(error.value)) <= 200
    np.testing.assert_array_equal(read_series("estimate", [0, 1, 2], Q.astype(object))[1], Q)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("given", [[-(2**63), 2**63 - 1], np.array([2**63, 2**63 + 1], dtype=np.uint64)])
def test_a_stamp_that_no_message_can_have_is_refused(given):
    with pytest.raises(InputError, match=r"those of ROS 2 are within 2\*\*31 s: give nanoseconds") as error:
        read_stamps("estimate", np.asarray(given))
    assert len(str(error.value)) <= 200
    assert read_stamps("estimate", [-(2**31) * 10**9, 2**31 * 10**9]).dtype == np.int64
