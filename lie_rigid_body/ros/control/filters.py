"""Filters by name: regular expressions that are matched in a time with a bound, as nothing is tried twice."""

from __future__ import annotations

import re
from typing import Final

from lie_rigid_body.foundation.errors import LieRigidBodyError
from lie_rigid_body.foundation.wording import shown

MAX_FILTER: Final = 64
"""Largest number of characters of a filter."""
MAX_QUANTIFIERS: Final = 4
QUANTIFIERS: Final = "*+?{|"
_ATOM: Final = r"(?:\\[^\dNUux]|\[(?!\^?\])(?:\\.|[^\\\]])+\]|[^\\\[()|*+?])"
_REPEAT: Final = r"(?:[*+?]|\{(?:\d+|\d*,\d*)\})"
_PART: Final = re.compile(rf"((?:{_ATOM}(?!{_REPEAT}))+|{_ATOM})({_REPEAT}?)\??|\((?:\?:)?|\)\??(?![*+?{{])|\|")
"""A part of a filter: characters of one length, or one that is repeated; begin and end of a group; an alternative."""


def is_found(pattern: str, name: str) -> bool:
    """Whether a regular expression finds something in a name.

    The ends of all matches of the parts so far are kept as a set, and each part is matched from there once (Thompson's
    algorithm, Communications of the ACM 11, 1968, 419). A repeated group would need more than one pass.

    Raises
    ------
    LieRigidBodyError
        If it is none, or has more than is matched so.
    """
    parts = list(_PART.finditer(pattern))
    if (
        len(pattern) > MAX_FILTER
        or sum(map(pattern.count, QUANTIFIERS)) > MAX_QUANTIFIERS
        or (_is_valid(pattern) and "".join(part[0] for part in parts) != pattern)
    ):
        raise LieRigidBodyError(
            f"filter {shown(pattern)} is too complex: give at most {MAX_FILTER} characters, {MAX_QUANTIFIERS} of "
            f"{' '.join(QUANTIFIERS)}, none but ? behind a group, no (? but (?:, and no back reference"
        )
    starts = ends = set(range(len(name) + 1))
    others = set[int]()  # ends of the alternatives before
    outer = []
    for part in parts:
        if part[1]:
            ends = _ends(part[1], part[2], name, ends)
        elif part[0] == "|":
            others = others | ends
            ends = starts
        elif part[0].startswith("("):
            outer.append((starts, others))
            starts = ends
            others = set()
        else:
            ends = ends | others | (starts if part[0] == ")?" else set())
            starts, others = outer.pop()
    return bool(ends | others)


def _is_valid(pattern: str) -> bool:
    try:
        re.compile(pattern)
    except (re.error, OverflowError) as error:
        raise LieRigidBodyError(
            f"filter {shown(pattern)} is no regular expression ({error}): give another, or none"
        ) from None
    return True


def _ends(atom: str, repeat: str, name: str, starts: set[int]) -> set[int]:
    """Ends of all matches from some starts: those of a repeated character lie between the shortest and the longest."""
    longest = re.compile(atom + repeat).match
    if not repeat:
        return {found.end() for start in starts if (found := longest(name, start))}
    shortest = re.compile(f"{atom}{repeat}?").match
    pairs = [(shortest(name, start), longest(name, start)) for start in starts]
    return {end for low, high in pairs if low and high for end in range(low.end(), high.end() + 1)}
