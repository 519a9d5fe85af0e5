"""Mutated files keep the laws of `fuzzing`: those that once broke one, and those of a minute.

Cases are children of a process of their own: this one may hold more memory, after other tests, than a case may take.
"""

from __future__ import annotations

import os
import struct
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from multiprocessing import get_context
from pathlib import Path

import pytest

import fuzzing
import mutations
from foreign_bags import PLAIN, messages_of

pytestmark = [
    pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork"),
    pytest.mark.filterwarnings("ignore:This process.*is multi-threaded:DeprecationWarning"),  # of libraries, which wait
]
MINUTES = 0.5


@pytest.fixture(scope="module")
def bags() -> dict[str, bytes]:
    return mutations.honest()


@pytest.fixture(scope="module")
def parent(request: pytest.FixtureRequest) -> Iterator[ProcessPoolExecutor]:
    """The process whose children cases are; what draws is for the slow ones."""
    draw = bool(request.config.getoption("--run-slow") or request.config.getoption("-m"))
    warmed = partial(fuzzing.warmed, draw=draw)
    with ProcessPoolExecutor(1, get_context("spawn"), initializer=warmed) as pool:
        yield pool


DRAWING = {"check --report", "plot"}


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.slow) if name in DRAWING else name
        for name in mutations.VERBS
        if name != "campaign"
    ],
)
def test_honest_files_keep_the_laws_in_each_verb(
    bags: dict[str, bytes], parent: ProcessPoolExecutor, name: str
) -> None:
    original = "estimate" if name == "evaluate" else "exact"
    found = parent.submit(fuzzing.outcome, mutations.of_verb(name, bags[original], original), bags).result()
    assert (found.status, found.broken) == (0, "")


@pytest.mark.slow
@pytest.mark.parametrize("path", sorted(fuzzing.KEPT.glob("*.json")), ids=lambda path: path.stem)
def test_what_broke_a_law_keeps_it(bags: dict[str, bytes], parent: ProcessPoolExecutor, path: Path) -> None:
    assert parent.submit(fuzzing.outcome, fuzzing.read(path), bags).result().broken == ""


def test_each_law_is_held(bags: dict[str, bytes], tmp_path: Path) -> None:
    """By cases that are made to break it: the fuzzer that cannot fail finds nothing."""
    case = mutations.of_verb("check", bags["exact"], "exact")
    (tmp_path / "x.mcap").write_bytes(bags["exact"])
    found = fuzzing.Outcome(0, "")

    def broken(case: mutations.Case, outcome: fuzzing.Outcome = found, out: str = "", err: str = "") -> str:
        return next(fuzzing.broken_laws(case, outcome, out, err, tmp_path, bags), "")

    assert broken(case) == ""
    assert "status 3" in broken(case, found._replace(status=3))
    assert "status -15" in broken(case, found._replace(status=-15))
    assert broken(replace(case, signal=15), found._replace(status=-15)) == ""
    assert "took more" in broken(case, found._replace(status=-24))
    assert "MiB" in broken(case, found._replace(memory=600 * 2**20))
    assert "Traceback" in broken(case, err="Traceback (most recent call last):")
    assert "Warning" in broken(case, err="x.py:1: RuntimeWarning: overflow")
    assert "0 lines" in broken(case, found._replace(status=2))
    assert "terminal" in broken(case, out="\x1b[2J")
    (tmp_path / "other").touch()
    assert broken(case) == "wrote other"
    (tmp_path / "other").unlink()
    (tmp_path / "x.mcap").write_bytes(b"")
    assert broken(case) == "changed x.mcap"
    messages = messages_of(bags["exact"])
    forged = [m._replace(data=m.data[:-1] + b"\x40") if m.topic == "/pose" else m for m in messages]
    content = mutations.rewritten(forged, "lie_rigid_body")
    (tmp_path / "x.mcap").write_bytes(content)
    assert broken(replace(case, files={"x.mcap": content})).startswith("certified another /pose")


def replaced(content: bytes, topic: str, number: int | None, at: int, piece: bytes) -> bytes:
    """A bag with a piece of the payload of one message of a topic, or of each, overwritten, without checksums."""
    messages, count = messages_of(content), 0
    for i, message in enumerate(messages):
        if message.topic == topic:
            if number in (count, None):
                begin = at % len(message.data)
                data = message.data[:begin] + piece + message.data[begin + len(piece) :]
                messages[i] = message._replace(data=data)
            count += 1
    return mutations.rewritten(messages, "lie_rigid_body", PLAIN, checksums=False)


NORM_UNDERFLOWS = ("/pose", 0, 76, struct.pack("<Q", 1), {"check": {1}})
EDGES = [
    (
        topic,
        number,
        -8 * fields,
        fields * struct.pack("<d", value),
        {"check": {1}, "plot": {0, 2}, "evaluate": {0, 1, 2}},
    )
    for topic, fields in (("/pose", 7), ("/twist", 6))
    for value in (float("nan"), float("inf"), -1e308, 1e308, 5e-324)
    for number in (3, None)
]


@pytest.mark.parametrize(
    ("topic", "number", "at", "piece", "statuses"),
    [NORM_UNDERFLOWS, *(pytest.param(*edge, marks=pytest.mark.slow) for edge in EDGES)],
)
def test_numbers_at_the_edges_of_float64_are_judged_and_drawn_without_a_warning(
    bags: dict[str, bytes], parent: ProcessPoolExecutor, topic: str, number: int | None, at: int, piece: bytes,
    statuses: dict[str, set[int]],
) -> None:  # fmt: skip
    content = replaced(bags["estimate"], topic, number, at, piece)
    for verb, allowed in statuses.items():
        found = parent.submit(fuzzing.outcome, mutations.of_verb(verb, content, "estimate"), bags).result()
        assert found.broken == ""
        assert found.status in allowed


@pytest.mark.slow
def test_mutated_files_keep_the_laws_for_half_a_minute(
    parent: ProcessPoolExecutor, record_property: Callable[[str, object], None]
) -> None:
    counts, broken = parent.submit(fuzzing.fuzz, MINUTES, seed=int(time.time()) // 86400, keep=False).result()
    record_property("cases", counts["cases"])
    record_property("MiB at most", counts["MiB at most"])
    assert broken == []
    assert counts["cases"] > 10
