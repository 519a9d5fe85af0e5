"""What a diagnosis says first: a mistake, probes that failed, and why a filter cannot be diagnosed."""
# mypy: ignore-errors

from __future__ import annotations

import textbook

from lie_rigid_body import InputError
from lie_rigid_body.diagnosis import FilterDiagnosis, Mistake, Probe, diagnose

RIGHT = Probe("follows", True, "it errs by 0°", 0.0)
NOISE = Probe("noise", False, "it errs by 9°", 9.0)
FINITE = Probe("finite", False, "attitudes that are NaN: 3", 3.0)
MISTAKE = Mistake("inverted", "The quaternion is the inverse.", "undone", 90.0, 0.0)


def found(*probes, mistakes=(), rms_deg=0.0, interrupted=False):
    return FilterDiagnosis(mistakes, probes, (), 1, rms_deg, 0.1, interrupted=interrupted)


REFUSED = {
    InputError: [
        lambda: diagnose(lambda run: textbook.raises(run)),
        lambda: diagnose(lambda run: textbook.of_wrong_shape(run)),
        lambda: diagnose(lambda run: textbook.changes_its_run(run)),
        lambda: diagnose(lambda run: textbook.changes_its_estimate(run)),
        lambda: diagnose(lambda run: textbook.unreadable(run)),
        lambda: diagnose(lambda run: textbook.first_reading(run)),
        lambda: diagnose(lambda run: textbook.peeks(run)),
    ]
}
SAID = [
    lambda: found(RIGHT),
    lambda: found(RIGHT, NOISE),
    lambda: found(NOISE, FINITE, rms_deg=20.0),
    lambda: found(rms_deg=20.0, interrupted=True),
    lambda: found(NOISE, mistakes=(MISTAKE,), rms_deg=90.0),
]
