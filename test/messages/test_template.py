"""Rows of bytes are the same however many there are, one by one or by arrays."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from lie_rigid_body.messages.layout import Template

GAP = 3
"""Bytes between two rows in the data."""
ROW = bytes(range(100, 141))
RUNS = [(1, 1), (12, 2), (33, 1)]


def words_of(count: int) -> NDArray[np.int64]:
    whole = np.iinfo(np.int64)
    return np.random.default_rng(count).integers(whole.min, whole.max, (count, 4), dtype="<i8", endpoint=True)


def by_hand(words: NDArray[np.int64]) -> list[bytes]:
    rows = []
    for word in words.tolist():
        row = bytearray(ROW)
        for at, value in zip((1, 12, 20, 33), word, strict=True):
            row[at : at + 8] = value.to_bytes(8, "little", signed=True)
        rows.append(bytes(row))
    return rows


def put(words: NDArray[np.int64]) -> bytes:
    """The data that rows are put into, in descending order and with gaps between them."""
    step = len(ROW) + GAP
    data = np.zeros(step * len(words), dtype=np.uint8)
    Template(ROW, RUNS).put(data, step * np.arange(len(words))[::-1], words)
    return data.tobytes()


def laid_out(words: NDArray[np.int64]) -> bytes:
    return b"".join(row + bytes(GAP) for row in by_hand(words)[::-1])


COUNTS = pytest.mark.parametrize("count", [0, 1, 8, 9, 2000])


@COUNTS
def test_rows_are_the_template_with_their_words(count: int) -> None:
    words = words_of(count)
    assert list(Template(ROW, RUNS).rows(words)) == by_hand(words)


@COUNTS
def test_rows_are_put_at_their_places(count: int) -> None:
    assert put(words_of(count)) == laid_out(words_of(count))


@pytest.mark.parametrize("count", [2, 20])
def test_a_head_has_its_words_before_those_of_the_rows(count: int) -> None:
    head = bytes(10)
    words, own = words_of(count), np.arange(count, dtype="<i8")[:, np.newaxis]
    behind = Template(ROW, RUNS).behind(head, [(2, 1)])
    expected = [bytes(2) + k.to_bytes(8, "little") + row for k, row in enumerate(by_hand(words))]
    assert list(behind.rows(np.hstack([own, words]))) == expected


@given(st.lists(st.binary(min_size=20, max_size=20), min_size=1, max_size=12))
def test_rows_come_back_from_their_words(rows: list[bytes]) -> None:
    whole = Template(bytes(20), [(0, 2), (12, 1)])
    words = whole.words(np.frombuffer(b"".join(rows), dtype=np.uint8).reshape(-1, 20))
    assert list(whole.rows(words)) == rows
