"""Findings: which causes are named, and each in one sentence, with numbers and what to do."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Final

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.evaluation.causes import BY_CODE, Part, Track, fit, undone
from lie_rigid_body.evaluation.clock import Clock
from lie_rigid_body.evaluation.estimate import period_ns
from lie_rigid_body.evaluation.explanations import (
    FEWEST,
    FOLLOWING,
    FORMS,
    LATE,
    NEGLIGIBLE,
    TIE,
    Evidence,
    Explanation,
    is_needed,
    is_small,
    spread,
)
from lie_rigid_body.evaluation.statistics import rms
from lie_rigid_body.wording import short_repr

OF_SENSORS: Final = float(np.radians(1.0))
"""Error that sensors make, rad; it is nearer to a constant turn than to a lag."""
LAG_TIE: Final = 3.0
"""Ratio of two errors up to which a lag is told as an alternative to a cause of such a small error."""


FITTED: Final = 2000
"""Largest number of samples that the numbers in a finding are fitted to."""


@dataclass(frozen=True)
class Naming:
    """What is named, and what it rests on.

    Attributes
    ----------
    named : Explanation
        Without a cause where none is sure.
    evidence : Evidence
    tried : list of Explanation
        The cheapest first.
    of_sensors : bool
        Whether a constant turn was found that is no larger than what the sensors' own errors leave.
    at_limit : bool
        Whether a lag at the limit of the search leaves least: the true one may be longer.
    left_by_sensors : float
        As given to `choose`, rad.
    """

    named: Explanation
    evidence: Evidence
    tried: list[Explanation]
    of_sensors: bool = False
    at_limit: bool = False
    left_by_sensors: float = 0.0

    __repr__ = short_repr

    @property
    def follows(self) -> bool:
        """Whether up to three causes leave little, be they sure enough to be named or not: the body is followed."""
        plain = self.evidence.get(0, ()).error
        return any(e.error <= FOLLOWING * plain and e.explains for e in self.tried if 0 < len(e.causes) <= 3)

    def with_lag(self, lag_s: float | None) -> Naming:
        """The choice with a lag beside the causes that are named, if it is about the same without other turns."""
        if lag_s is None or self.named.lag_s is not None or self.named.turned not in LATE or self.evidence.spins:
            return self
        late = self.evidence.get(FORMS.index(self.named.form), self.named.turned, late=True)
        same = late.lag_s is not None and abs(late.lag_s - lag_s) <= 0.25 * abs(lag_s)
        small = is_small(self.evidence, late, self.left_by_sensors)
        return self if small or not same else replace(self, named=replace(late, lag_s=lag_s))

    def instead_of(self, cause: str) -> tuple[str, ...]:
        """Causes that, in the place of one, leave about as much."""
        rest = {*self.named.causes} - {cause}
        without, left = self.evidence.without(self.named, cause), max(self.named.error, NEGLIGIBLE)
        others = [*self.tried]
        if without.turned in LATE:
            others.append(self.evidence.get(FORMS.index(without.form), without.turned, late=True))
        found: dict[str, None] = {}
        for other in others:
            new = [name for name in other.causes if name not in rest]
            if len(new) != 1 or new[0] == cause or len(other.causes) != len(rest) + 1:
                continue
            small = new[0] == "lag" and without.error < OF_SENSORS
            most = min((LAG_TIE if small else TIE) * left, 0.5 * (without.error + left))
            if max(other.error, NEGLIGIBLE) <= most and (small or is_needed(self.evidence, other)):
                found[new[0]] = None
        return tuple(found)


def choose(track: Track, longest_lag_s: float, left_by_sensors: float = 0.0) -> Naming | None:
    """Choose the causes of an estimate's errors.

    Parameters
    ----------
    track : Track
        Samples whose true time, moved by the longest lag either way, is within the truth's times.
    longest_lag_s : float
    left_by_sensors : float
        Largest constant turn that the sensors' own errors leave to a right filter, rad.

    Returns
    -------
    Naming or None
        None of too few samples.
    """
    if len(track.stamps_ns) < FEWEST:
        return None
    evidence = Evidence(track, longest_lag_s)
    plain = evidence.get(0, ())
    if plain.error <= NEGLIGIBLE:
        return Naming(plain, evidence, [plain])
    choice = Naming(plain, evidence, evidence.explanations(), left_by_sensors=left_by_sensors)
    allowed: set[str] | None = None
    for e in choice.tried[: choice.tried.index(plain)]:
        if allowed is not None and not allowed.issuperset(e.causes):
            continue
        if e.lag_s is not None and abs(e.lag_s) > 0.999 * longest_lag_s:
            return replace(choice, at_limit=True)
        if not is_needed(evidence, e):
            continue
        if is_small(evidence, e, left_by_sensors):
            allowed = set(e.causes)  # what is left without the small turn is of its other causes
            choice = replace(choice, of_sensors=left_by_sensors > 0.0)
            continue
        return replace(choice, named=e)
    return choice


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
        doubt = _doubt(choice, "lag" if nearest[0].code in {"lagging", "leading"} else nearest[0].code)
        found.append(_finding(nearest, before, after, track, doubt))
        before = after
    return tuple(found) if rms(before) <= rms(given) else ()


def clock_finding(whole: Track, track: Track, clock: Clock) -> Finding:
    """Put another clock into words, of all samples and of those that it puts within the truth's times."""
    cause, constants = clock[0]
    sign = cause if len(clock) > 1 else BY_CODE["lagging" if constants[0] > 0.0 else "leading"]
    return _finding((sign, constants), _errors(whole, []), np.degrees(track.errors()), whole)


def _finding(part: Part, before: Array, after: Array, track: Track, doubt: str = "") -> Finding:
    """Put a cause into words, with the errors before and after it is undone, degrees."""
    (cause, constants), period_s = part, period_ns(track.stamps_ns) / 1e9
    fact, colon, remedy = cause.sentence(constants).partition(":")
    if cause.code in {"lagging", "leading"}:
        fact += f", {abs(constants[0]) / period_s:.3g} of its samples"
    return Finding(cause.code, f"{fact}{colon}{remedy} ({gain(before, after)}){doubt}.", rms(after))


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


def _doubt(choice: Naming, cause: str) -> str:
    others = [name.replace("_", " ") for name in choice.instead_of(cause)]
    if others and cause == "lag":
        others.append("an error of the gyro's scale or bias")
    return f"; this motion does not tell it from {' or '.join(others)}" if others else ""
