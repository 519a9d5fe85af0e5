"""Errors by name, and numbers of sentences: one table per room has the wording, all other tests have the values."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager

import pytest

Error = AbstractContextManager["pytest.ExceptionInfo[Exception]"]
"""What stands in a ``with``, where an error is to be raised."""


def numbers(text: str) -> list[float]:
    """The numbers of a sentence, in order."""
    return [float(number) for number in re.findall(r"-?\b\d+(?:\.\d+)?(?:e[-+]?\d+)?", text)]


def refusals(wording: Mapping[type[Exception], Mapping[str, str]]) -> Callable[..., Error]:
    """Function that gives the error of a name, which tells the values that are given.

    Parameters
    ----------
    wording : mapping
        For each type of error, and each name, the regular expression of what is said, with names of values in braces.
    """
    table = {name: (kind, said) for kind, named in wording.items() for name, said in named.items()}

    def refused(name: str, /, **values: object) -> Error:
        kind, said = table[name]
        return pytest.raises(kind, match=said.format_map({key: re.escape(str(value)) for key, value in values.items()}))

    return refused
