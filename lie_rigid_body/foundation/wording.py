"""Values and names in few words, for error lines and reprs: one line of bounded length, whatever is given.

NumPy is not imported here: an error line must not wait for it.
"""

from __future__ import annotations

import difflib
import os
import re
import reprlib
import sys
from collections.abc import Collection, Iterable, Mapping
from itertools import islice
from typing import Any, Final

LONGEST_LINE: Final = 200
"""Largest length of an error line or a repr, characters."""

LONGEST_VALUE: Final = 60
"""Largest length of a value in a line, characters."""

MOST_NAMES: Final = 5
"""Largest number of names listed in a line."""

_GAP: Final = "..."
_SHORT_WORD: Final = 24
"""Length, characters, to which long words are cut before words are left out."""
_SHORT_PATH: Final = 40
"""Length, characters, up to which only the end of a path is kept, with the name of the file."""
_MOST_NUMBERS: Final = 7

_NUMERAL: Final = re.compile(r"(?<!\w)[-+]?\d[\d.]*(?:[eE][-+]?\d+)?")


class _ShortRepr(reprlib.Repr):
    """Reprs that show the ends of what is long, and the shape of an array."""

    def __init__(self) -> None:
        super().__init__()
        self.maxlevel = 3
        self.maxlist = self.maxtuple = _MOST_NUMBERS
        self.maxdict = self.maxset = self.maxfrozenset = 4
        self.maxstring, self.maxother = LONGEST_VALUE - 8, sys.maxsize

    def repr_float(self, x: float, level: int) -> str:
        """Nine digits of a number that has more."""
        exact = repr(x)
        return exact if len(exact) <= 12 else f"{x:.9g}"

    def repr_int(self, x: int, level: int) -> str:
        """All digits, or how many there are: Python refuses to print very many."""
        return repr(x) if x.bit_length() <= 128 else f"<{'-' if x < 0 else ''}2**{x.bit_length() - 1} or more>"

    def repr_instance(self, x: Any, level: int) -> str:
        """Repr of an object; of a long one in the form of a call its name alone."""
        text, call = super().repr_instance(x, level), f"{type(x).__name__}("
        is_long_call = text.startswith(call) and len(text) > self.maxstring
        return f"{call}{_GAP})" if is_long_call else _without_middle(text, self.maxstring)

    def repr_array(self, x: Any, level: int) -> str:
        """The numbers, as of a list: ROS gives lists of numbers so."""
        return self.repr1(x.tolist(), level)

    def repr_ndarray(self, x: Any, level: int) -> str:
        """The numbers of a short row, or shape and ends of more."""
        if x.ndim == 0 or (x.ndim == 1 and x.size <= _MOST_NUMBERS):
            return self.repr1(x.tolist(), level)
        if x.size == 0:
            return f"<array of shape {x.shape}>"
        rows = x.reshape(-1, x.shape[-1]) if x.ndim > 1 and x.shape[-1] <= _MOST_NUMBERS else x.reshape(-1)
        first, last = rows[[0, -1]].tolist()
        return f"<{x.shape}, {_ends(first)} to {_ends(last)}>"


def _ends(value: object) -> str:
    """A number, or a row of them, to three digits."""
    if isinstance(value, list):
        return f"[{', '.join(map(_ends, value))}]"
    return f"{value:.3g}" if isinstance(value, float | complex) else _SHORT.repr(value)


_SHORT: Final = _ShortRepr()


def shown(value: object, most: int = LONGEST_VALUE) -> str:
    """A value as an error line repeats it: its repr on one line; of arrays, lists and texts that are long the ends.

    Parameters
    ----------
    value : object
    most : int, optional
        Largest length of the result, characters.

    Returns
    -------
    str
    """
    return shortened(_SHORT.repr(value), most)


def printable(text: str) -> str:
    """A text with escapes in place of what would control a terminal, and of bytes of a name that are no characters."""
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)


def shortened(text: str, most: int = LONGEST_LINE) -> str:
    """A text on one line of bounded length.

    Words that are long, such as values and paths, lose their middle first. Those after the last colon, in a message the
    remedy, do so only if the others do not suffice. Then the text loses words of its own. What is left ends with its
    end.

    Parameters
    ----------
    text : str
    most : int, optional
        Largest length of the result, characters.

    Returns
    -------
    str
    """
    # of a text that is far longer, no more is looked at
    words = printable(_without_middle(" ".join(text.splitlines()), 50 * most)).split(" ")
    remedy = max((i for i, word in enumerate(words, 1) if word.endswith(":")), default=0)
    for end in (remedy, len(words)):
        while (excess := len(" ".join(words)) - most) > 0:
            longest = max(words[:end], key=len, default="")
            if len(longest) <= _SHORT_WORD:
                break
            words[words.index(longest)] = _short_word(longest, max(_SHORT_WORD, len(longest) - excess))
    return _without_middle_words(words, most)


def _short_word(word: str, most: int) -> str:
    is_path = os.path.basename(word) != word and most <= _SHORT_PATH
    return f"{_GAP}{word[len(_GAP) - most :]}" if is_path else _without_middle(word, most)


def _without_middle_words(words: list[str], most: int) -> str:
    """Words, as many from the start and, of what room there is twice as many, from the end."""
    text, room = " ".join(words), most - len(_GAP)
    if len(text) <= most:
        return text
    head = text.rfind(" ", 0, room // 3) + 1 or _outside_numbers(text, room // 3, len(text))[0]
    begin = len(text) - room + head
    space = text.find(" ", begin)
    return f"{text[:head]}{_GAP}{text[space if space >= 0 else _outside_numbers(text, 0, begin)[1] :]}"


def _without_middle(text: str, most: int) -> str:
    if len(text) <= most:
        return text
    head = (most - len(_GAP)) // 3
    head, tail = _outside_numbers(text, head, len(text) + head + len(_GAP) - most)
    return f"{text[:head]}{_GAP}{text[tail:]}"


def _outside_numbers(text: str, head: int, tail: int) -> tuple[int, int]:
    """Ends of the two parts of a text that are left, moved so that no number is cut but one of very many digits."""
    for number in _NUMERAL.finditer(text):
        start, end = number.span()
        if end - start <= LONGEST_VALUE // 3:
            head = start if start < head <= end else head
            tail = end if start <= tail < end else tail
    return head, tail


def listed(names: Collection[object]) -> str:
    """Names with commas between them; of many the first, and how many more there are.

    Parameters
    ----------
    names : collection of object

    Returns
    -------
    str
    """
    first = ", ".join(shortened(str(name), LONGEST_VALUE) for name in islice(names, MOST_NAMES))
    return first if len(names) <= MOST_NAMES else f"{first} and {len(names) - MOST_NAMES} more"


def components(vector: Iterable[float], digits: int) -> str:
    """Components of a vector of length 1 with so many digits; what is round-off is 0."""
    return ", ".join(f"{round(float(v), digits + 1) + 0.0:.{digits}g}" for v in vector)


def numerals(numbers: Iterable[float]) -> str:
    """Numbers to six digits, enough to recognise them elsewhere, with commas between them."""
    return ", ".join(f"{number:.6g}" for number in numbers)


def counted(count: int, noun: str) -> str:
    """A number of things, with an s where there is not one."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def suggestion(name: str, known: Collection[str], kind: str) -> str:
    """A hint for an unknown name: the known names most like it, or else the first of all.

    Parameters
    ----------
    name : str
    known : collection of str
    kind : str
        What the names are called, in the plural.

    Returns
    -------
    str
    """
    near = difflib.get_close_matches(name[:LONGEST_VALUE], known, n=3)
    return f"did you mean {' or '.join(near)}?" if near else f"the {kind} are {listed(known)}"


def call_repr(instance: object, arguments: Mapping[str, object]) -> str:
    """A repr in the form of a call of the instance's class, with as many arguments, `shown`, as there is room for.

    Parameters
    ----------
    instance : object
    arguments : mapping of str to object

    Returns
    -------
    str
        Of at most `LONGEST_LINE` characters.
    """
    given = [f"{name}={shown(value)}" for name, value in arguments.items()]
    call = f"{type(instance).__name__}({', '.join(given)})"
    while len(call) > LONGEST_LINE:
        given.pop()
        call = f"{type(instance).__name__}({', '.join(given)}, {_GAP})"
    return call
