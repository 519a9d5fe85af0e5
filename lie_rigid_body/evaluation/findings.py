"""Findings: each cause of a diagnosis in one sentence, with numbers and what to do."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.evaluation.alignment import HEADING, LAG, MOUNTING, Misalignment, RunComparison, fit
from lie_rigid_body.evaluation.clock import StampClock, by_clock
from lie_rigid_body.evaluation.diagnosis import Diagnosis
from lie_rigid_body.evaluation.estimate import period_ns
from lie_rigid_body.evaluation.explanation import Explanation
from lie_rigid_body.evaluation.search import spread, written
from lie_rigid_body.evaluation.statistics import rms
from lie_rigid_body.evaluation.turning import named
from lie_rigid_body.lie import quaternion
from lie_rigid_body.wording import components, short_repr

FITTED = 2000
"""Largest number of samples that the numbers in a finding are fitted to."""

SAME_AXES_DEG = 5.0
"""Largest angle between a mounting and axes that only change places and signs, to be told in those words, degrees."""

OF_SENSORS: Final = float(np.radians(20.0))
"""Largest turn of the body's axes that errors of the sensors feign, rad: they keep to the body as a mounting does."""


@dataclass(frozen=True)
class Finding:
    """Mistake in an estimate, with what to do.

    Attributes
    ----------
    code : str
        ``inverted``, ``scalar_first``, ``ned_world``, ``heading_offset``, ``body_mounting``, ``lagging``, ``leading``,
        ``clock_rate``, ``world_turned``, ``stuck``, ``mixed``, ``turn_rate``, ``turn_axes``, ``gaps`` or ``not_unit``.
    message : str
        One sentence with numbers, and what to do.
    rms_deg_after : float
        RMS of the total error that is left when this cause and those before it are undone, degrees.
    """

    code: str
    message: str
    rms_deg_after: float

    __repr__ = short_repr

    def to_json(self) -> dict[str, str | float]:
        """JSON-serialisable data: code, message and what is left."""
        return asdict(self)


def findings(comparison: RunComparison, diagnosis: Diagnosis) -> tuple[Finding, ...]:
    """Put the causes of a diagnosis into words, in the order in which they are undone.

    Parameters
    ----------
    comparison : RunComparison
        Of all samples.
    diagnosis : Diagnosis

    Returns
    -------
    tuple of Finding
        Empty if the errors grow when all causes are undone, as where most of them are of something else.
    """
    found: list[Finding] = []
    before = given = np.degrees(comparison.angles(Misalignment()))
    fitted = _fitted(comparison, diagnosis.explanation)
    for cause, partial in _undone(diagnosis.explanation):
        # all constants are those of one fit: they hold together, and the last finding tells what they leave
        after = np.degrees(written(comparison, partial.convention).angles(fitted.only(partial.free)))
        sentence, doubt = _sentence(cause, comparison, diagnosis, fitted), _doubt(diagnosis, cause)
        found.append(Finding(_code(cause, fitted), f"{sentence} ({gain(before, after)}){doubt}.", rms(after)))
        before = after
    return tuple(found) if rms(before) <= rms(given) else ()


def clock_finding(comparison: RunComparison, clock: StampClock) -> Finding:
    """Put another clock into words.

    Parameters
    ----------
    comparison : RunComparison
        Of all samples, also those outside of the truth's times.
    clock : StampClock
    """
    before = np.degrees(comparison.angles(Misalignment()))
    after = np.degrees(by_clock(comparison, clock).angles(Misalignment()))
    if clock.rate == 1.0:
        code, sentence = ("lagging" if clock.lag_s > 0.0 else "leading"), _lag(comparison, clock.lag_s)
    else:
        code, sentence = "clock_rate", _rate(clock)
    return Finding(code, f"{sentence} ({gain(before, after)}).", rms(after))


def _rate(clock: StampClock) -> str:
    times = f"{max(clock.rate, 1.0 / clock.rate):.5g} times as {'slow' if clock.rate > 1.0 else 'fast'}"
    return (
        f"The clock of the estimate's stamps runs {times} as that of the truth: stamp it with the time of the readings "
        "it is made of, in their unit and with their period, not by another clock beside a replay"
    )


def gain(before: Array, after: Array) -> str:
    """Sentence about the errors before and after a cause is undone, degrees; alone it need not help."""
    if np.median(after) >= np.median(before):
        return "helps only together with what follows"
    return (
        f"median error {np.median(before):.3g}° before and {np.median(after):.3g}° after, "
        f"rms {rms(before):.3g}° and {rms(after):.3g}°"
    )


def _undone(best: Explanation) -> Iterator[tuple[str, Explanation]]:
    """Causes in their order, each with the explanation by it and those before it."""
    causes = best.causes
    for k, cause in enumerate(causes, 1):
        partial = best
        for later in causes[k:]:
            free, convention = partial.without(later)
            partial = Explanation(convention, free, best.misalignment, best.median)
        yield cause, partial


def _fitted(comparison: RunComparison, explanation: Explanation) -> Misalignment:
    """All constants of an explanation, fitted together to up to `FITTED` samples."""
    ours = written(comparison, explanation.convention)
    few = ours.inner()
    return fit(few.part(spread(len(few.stamps_ns), FITTED)), explanation.free, explanation.misalignment)


def _code(cause: str, fitted: Misalignment) -> str:
    if cause == LAG:
        return "lagging" if fitted.lag_s > 0.0 else "leading"
    return cause


def _sentence(cause: str, comparison: RunComparison, diagnosis: Diagnosis, fitted: Misalignment) -> str:
    if cause == "scalar_first":
        return "The quaternion comes scalar first, w x y z, where x y z w is read: move the first number to the end"
    if cause == "inverted":
        return "The quaternion is the inverse, it takes world vectors to the body: publish its conjugate, -x -y -z w"
    if cause == "ned_world":
        body = " and its body forward-right-down" if diagnosis.explanation.convention.frd_body else ""
        return (
            f"The world of the estimate is north-east-down{body}: turn it to z up by (√½, √½, 0, 0) from the left"
            f"{', and by (1, 0, 0, 0) from the right' if body else ''}; if it should not be, see whether the sign of "
            "the accelerometer turns it upside down"
        )
    if cause == HEADING:
        return _heading(fitted)
    if cause == MOUNTING:
        return _mounting(fitted)
    return _lag(comparison, diagnosis.lag_s if diagnosis.lag_s is not None else fitted.lag_s)


def _heading(fitted: Misalignment) -> str:
    angle = float(np.degrees(np.remainder(fitted.heading + np.pi, 2.0 * np.pi) - np.pi))
    return (
        f"The world of the estimate is turned by {angle:+.4g}° about the vertical: turn the estimate by {-angle:+.6g}° "
        "from the left, or tell the filter its magnetic declination or what its x axis is; hard iron and a bias of the "
        "gyro turn it as well"
    )


def _mounting(fitted: Misalignment) -> str:
    mounting = np.array(fitted.mounting) * (1.0 if fitted.mounting[3] >= 0.0 else -1.0)
    inverse = components(quaternion.conjugate(mounting), 6)
    doubt = (
        "; biases, hard iron and axes of the sensors turn them as well" if fitted.mounting_angle < OF_SENSORS else ""
    )
    return (
        f"The body axes of the estimate are turned by {angle_and_axis(mounting)} of the body: tell the "
        f"filter how the sensor is mounted, or multiply the estimate by ({inverse}) from the right{_places(mounting)}"
        f"{doubt}"
    )


def angle_and_axis(rotation: Array) -> str:
    """Angle and axis of a rotation, shape (4,), in words."""
    vector = quaternion.log(rotation)
    angle = float(np.sqrt(vector @ vector))
    return f"{np.degrees(angle):.4g}° about ({components(vector / angle if angle else vector, 3)})"


def _places(mounting: Array) -> str:
    """Body axes of an estimate named by those of the body, where they only change places and signs; else empty."""
    axes = quaternion.rotate(mounting, np.eye(3))  # row by row, on the axes of the body
    nearest = np.round(axes)
    left = float(np.degrees(np.arccos(np.clip((np.sum(axes * nearest) - 1.0) / 2.0, -1.0, 1.0))))
    name = named(nearest)
    if left > SAME_AXES_DEG or name == "x, y, z" or np.abs(nearest).sum() != 3.0:
        return ""
    meaning = ", forward-right-down where the truth's are forward-left-up" if name == "x, -y, -z" else ""
    return f"; its x, y, z are {name} of the body{meaning}" + (f", but for {left:.2g}°" if left >= 0.01 else "")


def _lag(comparison: RunComparison, lag_s: float) -> str:
    period = period_ns(comparison.stamps_ns) / 1e9
    late = lag_s > 0.0
    remedy = (
        "stamp it with the time of the readings it is made of"
        if late
        else "stamp it with the end of the last gyro step it contains"
    )
    return (
        f"The estimate is {'late' if late else 'ahead'} by {abs(lag_s):.4g} s, {abs(lag_s) / period:.3g} of its "
        f"samples: {remedy}"
    )


def _doubt(diagnosis: Diagnosis, cause: str) -> str:
    others = [name.replace("_", " ") for name in diagnosis.instead_of(cause)]
    if others and cause == LAG:
        others.append("an error of the gyro's scale or bias")
    return f"; this motion does not tell it from {' or '.join(others)}" if others else ""
