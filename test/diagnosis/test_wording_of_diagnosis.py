"""What a diagnosis says: its first sentences, why a filter cannot be diagnosed, and phrases that other tests name."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
import textbook

from lie_rigid_body import InputError
from lie_rigid_body.diagnosis import FilterDiagnosis, Mistake, Probe, diagnose

PHRASES = {
    "honest": " runs where 3 is honest",
    "deviations": "it is honest when it is squared: give variances, no standard deviations",
    "other axes": "it is honest about the other axes, of world and body: give covariance_axes",
    "unstable": "it is unstable: sensors off by ",
    "one attitude": "it begins with one attitude whatever it reads, and so do the bodies here",
    "heading": "its vertical is right, and its heading alone is wrong: see whether it uses the magnetometer",
    "bias removed": "it removes the bias",
}
"""Parts of what is told of probes."""

RIGHT = Probe("follows", True, "it errs by 0°", 0.0)
NOISE = Probe("noise", False, "it errs by 9°", 9.0)
FINITE = Probe("finite", False, "attitudes that are NaN: 3", 3.0)
MISTAKE = Mistake("inverted", "The quaternion is the inverse.", "undone", 90.0, 0.0)


def found(*probes: Probe, rms_deg: float = 0.0, interrupted: bool = False) -> FilterDiagnosis:
    return FilterDiagnosis((), probes, (), 1, rms_deg, 0.1, interrupted=interrupted)


SAID: dict[str, FilterDiagnosis] = {
    "No mistake: with perfect sensors the filter errs by 0.00°.": found(RIGHT),
    "No mistake: with perfect sensors the filter errs by 0.00°; it fails 1 probe: noise.\nnoise: it errs by 9°.": found(
        RIGHT, NOISE
    ),
    "Nothing that was tried mends the error of 20.0°; it fails 2 probes: noise, finite.\n"
    "finite: attitudes that are NaN: 3.": found(NOISE, FINITE, rms_deg=20.0),
    "Nothing so far mends the error of 20.0°.": found(rms_deg=20.0, interrupted=True),
    "The quaternion is the inverse.": FilterDiagnosis((MISTAKE,), (NOISE,), (), 1, 90.0, 0.1),
}
"""What is said first of a diagnosis: in one sentence whether there is a mistake, and which probes failed."""


@pytest.mark.parametrize("said", SAID)
def test_what_a_person_needs_to_know_is_said_first(said: str) -> None:
    assert str(SAID[said]) == said


@pytest.mark.parametrize(
    ("estimate", "said"),
    [
        (textbook.raises, ["textbook.py line ", "ZeroDivisionError: of the filter"]),
        (textbook.of_wrong_shape, ["(1300, 3)"]),
        (textbook.changes_its_run, ["(10, 4) for 1300 stamps"]),
        (textbook.changes_its_estimate, ["estimate: not numbers"]),
        (textbook.unreadable, ["textbook.py line ", "LookupError: where it is read"]),
        (textbook.first_reading, ["no attitude after 4.33 s"]),
        (textbook.peeks, ["textbook.py line ", "run.attitude() would tell the truth"]),
    ],
)
def test_filter_that_fails_is_refused_in_one_line(estimate: Callable[[Any], Any], said: list[str]) -> None:
    with pytest.raises(InputError) as caught:
        diagnose(lambda run: estimate(run))
    assert [word for word in said if word not in str(caught.value)] == []


@pytest.mark.parametrize(
    ("estimate", "said"),
    [
        (textbook.interrupts, ["textbook.py line ", "KeyboardInterrupt: of the filter"]),
        pytest.param(textbook.stops, ["textbook.py line ", ": BaseException: mend"], marks=pytest.mark.slow),
        pytest.param(
            textbook.spoils_its_process,
            ["the filter failed, ", "No module named 'numpy': mend"],
            marks=pytest.mark.slow,
        ),
        (textbook.endless, ["the filter failed, MemoryError: mend"]),
    ],
)
def test_filter_that_fails_in_a_process_of_its_own_is_refused_in_one_line(
    estimate: Callable[[Any], Any], said: list[str]
) -> None:
    with pytest.raises(InputError) as caught:
        diagnose(estimate, workers=1)
    assert [word for word in said if word not in str(caught.value)] == []
