"""Diagnosis of an estimate: which causes are named, and each in one sentence, with numbers and what to do."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, NamedTuple

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.evaluation.causes import BY_CODE, Finding, Part, Track, fit, undone
from lie_rigid_body.evaluation.clock import Clock, Lag, clock_lag, lag_of, other_clock
from lie_rigid_body.evaluation.explanations import FEWEST, TIE, Evidence, Explanation
from lie_rigid_body.evaluation.remarks import Turns
from lie_rigid_body.evaluation.statistics import rms
from lie_rigid_body.evaluation.truth import period_ns

LONGEST_LAG_S: Final = 1.0
"""Longest lag looked for, s, either way, unless the errors ask for more."""
MOST_NAMED: Final = 2
"""Number of causes, one if the world is turned, above which it is asked whether the turns have a simpler name."""
UNLIKE_DEG: Final = 5.0
"""Median error above which an estimate is asked whether it turns as the body does, degrees."""
FITTED: Final = 2000
"""Largest number of samples that the numbers in a finding are fitted to."""


class Diagnosis(NamedTuple):
    """What is found about an estimate beside its errors.

    Attributes
    ----------
    lag : Lag
    findings : tuple of Finding
        Mistakes, and remarks on how it turns.
    of_sensors : bool
        Whether a constant turn was found that is no larger than what the sensors' own errors leave.
    """

    lag: Lag = Lag()
    findings: tuple[Finding, ...] = ()
    of_sensors: bool = False


def diagnose(track: Track, whole: Track, longest_lag_s: float | None = None, sensors: float = 0.0) -> Diagnosis:
    """Find the lag and the mistakes, and what is wrong about the turns where nothing else is.

    Parameters
    ----------
    track : Track
        Samples within the truth's times.
    whole : Track
        All samples.
    longest_lag_s : float, optional
        As given to `evaluate`.
    sensors : float, optional
        Largest constant turn that the sensors' own errors leave to a right filter, rad.
    """
    stamps, truth, turned, error = track.stamps_ns, track.truth, Turns(track), np.degrees(track.errors())
    unlike = bool(np.median(error) > UNLIKE_DEG)
    sure = (turned.stuck() or turned.mixed()) if rms(error) > UNLIKE_DEG else ()
    if sure:  # of fast turns every sample jumps
        return Diagnosis(findings=turned.other() or sure if sure[0].code == "mixed" else sure)
    quarter = float(stamps[-1] - stamps[0]) / 4e9
    longest_s = min(LONGEST_LAG_S if longest_lag_s is None else longest_lag_s, quarter)
    margin = round(longest_s * 1e9)
    inner = track.part(truth.covers(stamps - margin) & truth.covers(stamps + margin))
    evidence = Evidence(inner, longest_s, sensors) if len(inner.stamps_ns) >= FEWEST else None
    choice = evidence and evidence.choice()
    causes = {*choice.named.causes} if choice else set[str]()
    at_limit = choice is not None and choice.at_limit
    lost = unlike and not causes and not (evidence and evidence.follows())
    # a motion that nearly repeats has a near lag with a mounting for each far one
    near = unlike and bool({"world_turned", "body_mounting", "lag"} & causes)
    found = other_clock(whole, 0.9 * longest_s) if longest_lag_s is None and (lost or at_limit or near) else None
    most = np.inf if not (choice and near) else (TIE if "lag" in causes else 0.5) * choice.named.error
    if found is not None and rms(found[1].errors()) <= most:
        clock, moved = found
        return Diagnosis(clock_lag(clock, moved), (_of_clock(whole, moved, clock),))
    if not evidence or not choice:
        return Diagnosis()
    lag = Lag() if at_limit else lag_of(inner, choice.named, longest_s, period_ns(stamps) / 1e9)
    named = choice.named if lag.lag_s is None or not lag.sure else evidence.with_lag(choice.named, lag.lag_s)
    told = _in_words(track, evidence, named) if named.causes else ()
    # a gyro on other axes is the same map as three conventions and a turned world
    many = len(told) > (1 if "world_turned" in named.turned else MOST_NAMED)
    other = turned.other() if (lost and not told) or many else ()
    return Diagnosis(lag, other or told, choice.of_sensors)


def _in_words(track: Track, evidence: Evidence, named: Explanation) -> tuple[Finding, ...]:
    """Put the causes that are named into words, in the order of their effect; those without constants come first.

    Nothing is said if the errors of all samples grow when all causes are undone, as where most are of something else.
    """
    parts, few = named.parts, track.part(slice(len(track.stamps_ns) // 4, None)).few(FITTED)
    rest = fit([few.part(few.truth.covers(undone(few, parts).stamps_ns))], parts)
    found, done, errors = list[Finding](), list[Part](), [_errors(track, [])]
    while rest:
        # all constants are those of one fit: they hold together, and the last finding tells what they leave
        fixed = [part for part in rest if not part[0].price]
        nearest = min(fixed[:1] or rest, key=lambda part: rms(_errors(track, [*done, part])))
        rest = [part for part in rest if part is not nearest]
        done.append(nearest)
        errors.append(_errors(track, done))
        others = evidence.instead_of(named, "lag" if nearest[0].code in {"lagging", "leading"} else nearest[0].code)
        found.append(_finding(nearest, errors[-2], errors[-1], track, others))
    return tuple(found) if rms(errors[-1]) <= rms(errors[0]) else ()


def _of_clock(whole: Track, track: Track, clock: Clock) -> Finding:
    """Put another clock into words, of all samples and of those that it puts within the truth's times."""
    cause, constants = clock[0]
    sign = cause if len(clock) > 1 else BY_CODE["lagging" if constants[0] > 0.0 else "leading"]
    known = whole.known()
    return _finding((sign, constants), _errors(known, []), np.degrees(track.errors()), known)


def _errors(track: Track, parts: Sequence[Part]) -> Array:
    """Errors without some causes where the truth is known, degrees."""
    return np.asarray(np.degrees(undone(track, parts).known().errors()))


def _finding(part: Part, before: Array, after: Array, track: Track, instead: Sequence[str] = ()) -> Finding:
    """Put a cause into words, with the errors before and after it is undone, degrees, and causes that do as well."""
    (cause, constants), others = part, [name.replace("_", " ") for name in instead]
    fact, colon, remedy = cause.sentence(constants).partition(":")
    if cause.code in {"lagging", "leading"}:
        fact += f", {abs(constants[0]) / (period_ns(track.stamps_ns) / 1e9):.3g} of its samples"
        others += ["an error of the gyro's scale or bias"] if others else []
    gain = (
        f"median error {np.median(before):.3g}° before and {np.median(after):.3g}° after, "
        f"rms {rms(before):.3g}° and {rms(after):.3g}°"
    )
    if np.median(after) >= np.median(before):  # alone it need not help
        gain = "helps only together with what follows"
    doubt = f"; this motion does not tell it from {' or '.join(others)}" if others else ""
    return Finding(cause.code, f"{fact}{colon}{remedy} ({gain}){doubt}.", rms(after))
