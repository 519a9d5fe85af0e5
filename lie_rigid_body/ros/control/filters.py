"""Filters by name: regular expressions that are matched in a time with a bound, as nothing is tried twice."""

from __future__ import annotations

import re
from typing import Final

from lie_rigid_body.foundation.errors import LieRigidBodyError
from lie_rigid_body.foundation.wording import shown

_ATOM: Final = r"(?:\\[^\dNUux]|\[(?!\^?\])(?:\\.|[^\\\]])+\]|[^\\\[()|*+?])"
_REPEAT: Final = r"(?:[*+?]|\{(?:\d+|\d*,\d*)\})"
_PART: Final = re.compile(rf"((?:{_ATOM}(?!{_REPEAT}))+|{_ATOM})({_REPEAT}?)\??|(\((?:\?:)?)|\)(\??)(?![*+?{{])|\|")
"""A part of a filter: characters of one length, or one that is repeated; begin and end of a group; an alternative."""


def is_found(pattern: str, name: str) -> bool:
    """Whether a regular expression finds something in a name.

    The ends of all matches of the parts so far are kept as a set, and each part is matched from there once. This is
    Thompson's algorithm (Communications of the ACM 11, 1968, 419). A repeated group would need more than one pass.

    Raises
    ------
    LieRigidBodyError
        If it is none, or has more than is matched so.
    """
    if len(pattern) > 64 or sum(map(pattern.count, "*+?{|")) > 4 or _PART.sub("", pattern):
        raise LieRigidBodyError(
            f"filter {shown(pattern)} is none that is matched in a short time: give at most 64 characters, 4 of "
            "* + ? { |, none but ? behind a group, no (? but (?:, and no back reference"
        )
    try:
        re.compile(pattern)
    except (re.error, OverflowError) as error:
        raise LieRigidBodyError(
            f"filter {shown(pattern)} is no regular expression ({error}): give another, or none"
        ) from None
    ends = set(range(len(name) + 1))
    groups = [(ends, set[int]())]  # of the whole and each that is open: the starts, and ends of alternatives before
    for part in _PART.finditer(pattern + ")"):
        atoms, repeat, begin, is_optional = part.groups()
        if atoms:  # where the same is repeated all ends between the shortest and the longest match are possible
            both = re.compile("(?=(?:{0}){1}?())(?:{0}){1}".format(atoms, repeat or "{1}"))
            ends = {
                end
                for start in ends
                if (found := both.match(name, start))
                for end in range(found.end(1), found.end() + 1)
            }
        elif begin:
            groups.append((ends, set()))
        elif part[0] == "|":
            groups[-1][1].update(ends)
            ends = groups[-1][0]
        else:
            starts, others = groups.pop()
            ends = ends.union(others, starts if is_optional else ())
    return bool(ends)
