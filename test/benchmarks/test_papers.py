"""Published numbers are found again."""

from __future__ import annotations

import pytest

import papers
from lie_rigid_body import RigidBody
from lie_rigid_body.foundation.errors import ParameterError


@pytest.mark.parametrize("published", papers.PUBLISHED, ids=lambda each: each.name)
def test_a_published_number_is_found(published):
    assert published.ours() == pytest.approx(published.number, abs=published.tolerance)
    assert len(published.source) > 20


@pytest.mark.parametrize("moments", [[2.0, 1.0, 2 / 3], [0.345, 0.653, 1.0]])
def test_a_body_that_no_mass_has_is_refused_with_the_way_that_takes_it(moments):
    with pytest.raises(ParameterError, match="Lagrangian"):
        RigidBody(moments)


def test_every_number_is_printed_with_its_lines(capsys):
    papers.main()
    printed = capsys.readouterr().out
    assert printed.count("published") >= len(papers.PUBLISHED)
    assert "describe(" in printed
    assert "published -0.035456085277494165, ours -0.03545608527749" in printed


def test_printed_lines_use_no_constant_of_the_file():
    constants = {name for name, value in vars(papers).items() if isinstance(value, float | list | tuple)}
    for published in papers.PUBLISHED:
        assert not constants & set(published.ours.__code__.co_names), published.name


def test_half_twists_are_not_rounded():
    assert papers.racket() % 0.5 > 0.01
