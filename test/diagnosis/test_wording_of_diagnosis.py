"""The sentences with which a diagnosis begins."""

from __future__ import annotations

import pytest

from lie_rigid_body.diagnosis import FilterDiagnosis, Mistake, Probe

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
