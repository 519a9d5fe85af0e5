"""Findings: each cause in one sentence, with numbers and what to do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.evaluation.causes import Part, Track, fit, undone
from lie_rigid_body.evaluation.clock import Clock, rate_of
from lie_rigid_body.evaluation.estimate import FEIGNED, period_ns
from lie_rigid_body.evaluation.naming import Naming, spread
from lie_rigid_body.evaluation.statistics import rms
from lie_rigid_body.evaluation.turning import named
from lie_rigid_body.lie import quaternion
from lie_rigid_body.wording import components, short_repr

FITTED: Final = 2000
"""Largest number of samples that the numbers in a finding are fitted to."""
SAME_AXES_DEG: Final = 5.0
"""Largest angle between a mounting and axes that only change places and signs, to be told in those words, degrees."""


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


def findings(track: Track, choice: Naming) -> tuple[Finding, ...]:
    """Put the causes that are named into words, in the order of their effect; those without constants come first.

    Parameters
    ----------
    track : Track
        All samples within the truth's times.
    choice : Naming

    Returns
    -------
    tuple of Finding
        Empty if the errors grow when all causes are undone, as where most of them are of something else.
    """
    parts, later = choice.named.parts, track.part(slice(len(track.stamps_ns) // 4, None))
    few = later.part(spread(len(later.stamps_ns), FITTED))
    rest = fit([few.part(np.flatnonzero(few.truth.covers(undone(few, parts).stamps_ns)))], parts)
    found: list[Finding] = []
    before = given = _errors(track, [])
    done: list[Part] = []
    while rest:
        # all constants are those of one fit: they hold together, and the last finding tells what they leave
        fixed = [part for part in rest if not part[0].price]
        nearest = min(fixed[:1] or rest, key=lambda part: rms(_errors(track, [*done, part])))
        rest = [part for part in rest if part is not nearest]
        done.append(nearest)
        after = _errors(track, done)
        code, sentence = nearest[0].code, _sentence(nearest, track)
        doubt = _doubt(choice, "lag" if code in {"lagging", "leading"} else code)
        found.append(Finding(code, f"{sentence} ({gain(before, after)}){doubt}.", rms(after)))
        before = after
    return tuple(found) if rms(before) <= rms(given) else ()


def clock_finding(whole: Track, track: Track, clock: Clock) -> Finding:
    """Put another clock into words, of all samples and of those that it puts within the truth's times."""
    before, after = _errors(whole, []), np.degrees(track.errors())
    rate = rate_of(clock)
    if rate == 1.0:
        [(_, constants)] = clock
        code = "lagging" if constants[0] > 0.0 else "leading"
        sentence = _lag(float(constants[0]), whole)
    else:
        times = f"{max(rate, 1.0 / rate):.5g} times as {'slow' if rate > 1.0 else 'fast'}"
        code, sentence = (
            "clock_rate",
            (
                f"The clock of the estimate's stamps runs {times} as that of the truth: stamp it with the time of the "
                "readings it is made of, in their unit and with their period, not by another clock beside a replay"
            ),
        )
    return Finding(code, f"{sentence} ({gain(before, after)}).", rms(after))


def gain(before: Array, after: Array) -> str:
    """Sentence about the errors before and after a cause is undone, degrees; alone it need not help."""
    if np.median(after) >= np.median(before):
        return "helps only together with what follows"
    return (
        f"median error {np.median(before):.3g}° before and {np.median(after):.3g}° after, "
        f"rms {rms(before):.3g}° and {rms(after):.3g}°"
    )


def _errors(track: Track, parts: Sequence[Part]) -> Array:
    """Errors without some causes where the truth is known, degrees."""
    return np.asarray(np.degrees(undone(track, parts).known().errors()))


def _sentence(part: Part, track: Track) -> str:
    cause, constants = part
    fact = cause.fact(constants).partition(":")[0]
    if cause.code == "ned_world":
        body = ", and by (1, 0, 0, 0) from the right" if constants[0] else ""
        return (
            f"{fact}: turn it to z up by (√½, √½, 0, 0) from the left{body}; if it should not be, see whether the sign "
            "of the accelerometer turns it upside down"
        )
    if cause.code == "heading_offset":
        return (
            f"{fact}: turn the estimate by {-np.degrees(constants[0]):+.6g}° from the left, or tell the filter its "
            f"magnetic declination or what its x axis is; hard iron and a bias of the gyro turn it too, and {FEIGNED}"
        )
    if cause.code == "world_turned":
        return (
            f"{fact}: see whether nothing corrects a wrong first attitude, or the accelerometer, the magnetometer or "
            f"what they are held against has the wrong sign or other axes; {FEIGNED}"
        )
    if cause.code == "body_mounting":
        inverse = components(quaternion.exp(-constants), 6)
        return (
            f"{fact}: tell the filter how the sensor is mounted, or multiply the estimate by ({inverse}) from the "
            f"right{places(quaternion.exp(constants))}; biases of the sensors turn them as well, and {FEIGNED}"
        )
    return _lag(float(constants[0]), track) if cause.price else cause.fact(constants)


def _lag(lag_s: float, track: Track) -> str:
    remedy = "the time of the readings it is made of" if lag_s > 0.0 else "the end of the last gyro step it contains"
    samples = abs(lag_s) / (period_ns(track.stamps_ns) / 1e9)
    return (
        f"The estimate is {'late' if lag_s > 0.0 else 'ahead'} by {abs(lag_s):.4g} s, {samples:.3g} of its samples: "
        f"stamp it with {remedy}"
    )


def places(mounting: Array) -> str:
    """Body axes of an estimate named by those of the body, where they only change places and signs; else empty."""
    axes = quaternion.rotate(mounting, np.eye(3))  # row by row, on the axes of the body
    nearest = np.round(axes)
    left = float(np.degrees(np.arccos(np.clip((np.sum(axes * nearest) - 1.0) / 2.0, -1.0, 1.0))))
    name = named(nearest)
    if left > SAME_AXES_DEG or name == "x, y, z" or np.abs(nearest).sum() != 3.0:
        return ""
    meaning = ", forward-right-down where the truth's are forward-left-up" if name == "x, -y, -z" else ""
    return f"; its x, y, z are {name} of the body{meaning}" + (f", but for {left:.2g}°" if left >= 0.01 else "")


def _doubt(choice: Naming, cause: str) -> str:
    others = [name.replace("_", " ") for name in choice.instead_of(cause)]
    if others and cause == "lag":
        others.append("an error of the gyro's scale or bias")
    return f"; this motion does not tell it from {' or '.join(others)}" if others else ""
