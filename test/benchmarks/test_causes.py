"""The benchmark of causes: on one motion that turns about every axis, no kind of case has a wrong name."""

from __future__ import annotations

import pytest

import causes
from said import numbers
from sampled import sampled

MOTION, GRADE = "tumbling_cubesat, faster", "tactical"


@pytest.fixture(scope="module", autouse=True)
def one_run():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(causes, "MOTIONS", {MOTION: causes.MOTIONS[MOTION]})
        patch.setattr(causes, "GRADES", (GRADE,))
        patch.setattr(causes, "SEEDS", 1)
        patch.setattr(causes, "RUNS", ((MOTION, GRADE, 0),))
        causes.everything.cache_clear()
        yield
    causes.everything.cache_clear()


@pytest.mark.parametrize(
    "number",
    sampled(range(len(causes.KINDS)), every=40),
    ids=lambda n: "+".join(causes.KINDS[n]),
)
def test_each_kind_of_mistake_has_its_name_and_what_is_none_has_no(number: int) -> None:
    result = causes.judged(number)
    assert result.right or not result.fair, result


def test_the_matrix_counts_every_case() -> None:
    results = [causes.judged(number) for number in (0, 1, len(causes.KINDS) - 1)]
    assert [line.split()[0] for line in causes.matrix(results)] == ["inverted", "scalar_first", "right"]
    assert numbers(causes.summary(results)[0])[:3] == [2, 2, 100.0]
