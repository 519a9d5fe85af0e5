"""The truth between its samples, and the reading of stamps, quaternions and numbers of any kind."""

from __future__ import annotations

import numpy as np
import pytest
from motions import MOTIONS, STAMPS, attitude, truth_of

from lie_rigid_body.evaluation import ExactTruth, SampledTruth, attitude_error
from lie_rigid_body.evaluation.arguments import read_series, read_stamps
from lie_rigid_body.evaluation.remarks import of_series
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.lie import quaternion

SPIN = quaternion.exp(np.outer(STAMPS * 1e-9, [0.3, -0.2, 0.9]))


@pytest.mark.parametrize("motion", MOTIONS)
def test_samples_are_given_back_to_the_bit(motion):
    samples = attitude(motion)
    truth = SampledTruth(STAMPS, samples)
    assert truth.covers(STAMPS).all()
    assert truth.uncertainty_at(STAMPS) == 0.0 < truth.uncertainty == truth.uncertainty_at(STAMPS[1:] - 1)
    np.testing.assert_array_equal(truth.at(STAMPS), quaternion.normalize(samples))


def test_a_steady_turn_is_interpolated_exactly_whatever_the_signs():
    signs = np.where(np.arange(len(STAMPS)) % 3 == 0, -1.0, 1.0)[:, np.newaxis]
    truth = SampledTruth(STAMPS, SPIN * signs)
    t = np.random.default_rng(1).integers(0, STAMPS[-1], 500)
    wanted = quaternion.exp(np.outer(t * 1e-9, [0.3, -0.2, 0.9]))
    assert attitude_error(truth.at(t), wanted).total.max() < 1e-14
    assert truth.uncertainty < 1e-14
    np.testing.assert_allclose(truth.states(t)[1], np.tile([0.3, -0.2, 0.9], (500, 1)), atol=1e-10)


@pytest.mark.parametrize("motion", MOTIONS)
def test_its_uncertainty_bounds_the_miss_and_is_not_far_above_it(motion):
    truth = SampledTruth(STAMPS, attitude(motion))
    t = np.random.default_rng(2).integers(0, STAMPS[-1], 4000)
    miss = attitude_error(truth.at(t), MOTIONS[motion].at(t).attitude_xyzw).total.max()
    assert 0.5 * truth.uncertainty < miss < 1.05 * truth.uncertainty + 1e-15


def test_nothing_is_interpolated_across_a_gap():
    kept = np.r_[0:100, 110:300]
    truth = SampledTruth(STAMPS[kept], SPIN[kept])
    inside = STAMPS[100:109] + 1
    assert not truth.covers(inside).any()
    assert truth.covers(STAMPS[[0, 99, 110, 299]]).all()
    assert not truth.covers(STAMPS[[300]]).any()
    assert SampledTruth(STAMPS[kept], SPIN[kept], longest_gap_ns=10**9).covers(inside).all()


@pytest.mark.parametrize("given", [lambda t_ns: None, lambda t_ns: "truth", lambda t_ns: [[0.0, 0.0, 0.0, 1.0]]])
def test_exact_truth_may_give_lists_of_a_quaternion_for_each_stamp(given):
    t = STAMPS[:5]
    truth = ExactTruth(lambda t_ns: SPIN[t_ns // STAMPS[1]].tolist(), 0, int(STAMPS[-1]))
    np.testing.assert_array_equal(truth.at(t), SPIN[:5])
    with pytest.raises(InputError, match=r"^truth: "):
        ExactTruth(given, 0, int(STAMPS[-1])).at(t)


def test_exact_truth_is_asked_in_order_and_once():
    asked = []

    def motion(t_ns):
        asked.append(t_ns)
        return SPIN[t_ns // STAMPS[1]]

    t = STAMPS[[[7, 3], [7, 100]]]
    np.testing.assert_array_equal(ExactTruth(motion, 0, 10**12).at(t), SPIN[[[7, 3], [7, 100]]])
    np.testing.assert_array_equal(asked, [STAMPS[[3, 7, 100]]])


@pytest.mark.parametrize("motion", MOTIONS)
def test_body_rate_is_the_motions(motion):
    t = STAMPS[5:-5:97]
    np.testing.assert_allclose(truth_of(motion).states(t)[1], MOTIONS[motion].at(t).body_rate, atol=1e-6)


def remarked(stamps: np.ndarray, given: np.ndarray) -> list[str]:
    return [
        remark.code for remark in of_series(stamps, np.diff(stamps, prepend=-1) > 0, given, SampledTruth(STAMPS, SPIN))
    ]


def test_one_missing_sample_is_a_gap_of_even_stamps_only():
    """Of stamps that are uneven by themselves, two periods are none."""
    assert remarked(np.delete(STAMPS, 70), np.delete(SPIN, 70, axis=0)) == ["gaps"]
    uneven = np.arange(len(STAMPS)) % 4 > 0
    assert remarked(STAMPS[uneven], SPIN[uneven]) == []


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
