"""The benchmark of public filters: what it does with their attitudes, and the page that has what it found."""

from __future__ import annotations

import re

import numpy as np
from scipy.spatial.transform import Rotation

import public_filters
from reader import DOCS


def test_attitudes_are_turned_and_those_that_are_not_finite_stay_so() -> None:
    turn, *attitudes = Rotation.from_rotvec(np.random.default_rng(1).normal(size=(4, 3)))
    given = np.array([each.as_quat() for each in attitudes] + [[np.nan, 0.0, 0.0, 1.0]])
    found = public_filters.product(turn.as_quat(), given)
    right = [(turn * each).as_matrix() for each in attitudes]
    np.testing.assert_allclose(Rotation.from_quat(found[:3]).as_matrix(), right, atol=1e-14)
    assert np.isnan(found[3]).any()


def test_the_first_attitude_is_that_of_a_level_body() -> None:
    turn = Rotation.from_euler("ZYX", [0.7, -0.4, 0.3])
    force, field = turn.inv().apply([[0.0, 0.0, 9.8], [0.0, 2e-5, -4e-5]])
    found = Rotation.from_quat(public_filters.first_attitude(force[np.newaxis], force[np.newaxis], field[np.newaxis]))
    assert (found.inv() * turn).magnitude() < 1e-12


def test_the_page_names_filters_that_there_are() -> None:
    text = (DOCS / "explanation" / "what_it_found.md").read_text(encoding="utf-8")
    named = set(re.findall(r"^\| `(\w+)` \|", text, re.MULTILINE))
    assert len(named) > 8
    assert named <= set(public_filters.FILTERS)
    for library in {each.library for each in public_filters.FILTERS.values()}:
        assert (public_filters.SHIMS / f"{library.shim}.cpp").is_file()
        assert library.repository.split("/")[1] in text
