"""Moments of grids and densities, against closed forms, scipy and sums; and what is no distribution of mass."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import nquad
from scipy.special import erf

from lie_rigid_body import ParameterError
from lie_rigid_body.mechanics import ball, box, moments_of_density, moments_of_points, moments_on_grid
from random_masses import assert_same

OF_DENSITY: Any = moments_of_density
"""The function without its types, which refuse as well."""
POINTS = np.vstack([np.eye(3), -np.eye(3)])


@pytest.mark.parametrize("shape", [(5,), (1, 1), (3, 4), (2, 3, 4), (2, 1, 3, 2)])
def test_a_grid_of_one_density_is_a_box_whatever_its_cells(shape):
    n = len(shape)
    low, edges = np.linspace(-1.0, 0.5, n), 0.4 + np.arange(n)
    body = moments_on_grid(np.full(shape, 2.5), low, low + edges)
    expected = box(2.5 * np.prod(edges), edges).moved(np.eye(n), low + edges / 2)
    assert_same(body, expected, 1e-14)


def test_a_grid_is_the_sum_of_its_cells():
    rng = np.random.default_rng(2)
    rho, low, steps = rng.uniform(0.0, 2.0, (3, 2, 4)), np.array([-1.0, 0.5, 2.0]), np.array([0.2, 0.7, 0.3])
    cells = None
    for index in np.ndindex(rho.shape):
        cell = box(rho[index] * np.prod(steps), steps).moved(np.eye(3), low + steps * (np.array(index) + 0.5))
        cells = cell if cells is None else cells + cell
    assert_same(moments_on_grid(rho, low, low + steps * rho.shape), cells)


def test_a_finer_grid_of_a_smooth_density_is_of_second_order():
    exact = nquad(lambda x, y: x * y * np.exp(-x * x - x * y), [(-1, 1), (0, 2)])[0]
    errors = []
    counts = [10, 20, 40, 80]
    for count in counts:
        x, y = np.meshgrid(
            -1 + 2 * (np.arange(count) + 0.5) / count, 2 * (np.arange(count) + 0.5) / count, indexing="ij"
        )
        errors.append(abs(moments_on_grid(np.exp(-x * x - x * y), [-1, 0], [1, 2]).second_moment[0, 1] - exact))
    assert np.polyfit(np.log(counts), np.log(errors), 1)[0] == pytest.approx(-2.0, abs=0.05)


def gaussian(x):
    return np.exp(-np.sum(x**2, axis=1) + x[:, 0] * x[:, -1])


def test_a_density_function_by_nested_quadrature():
    ends = [(-1.0, 0.5), (0.2, 2.0)]
    body = moments_of_density(gaussian, ends)

    def moment(i, j):
        return nquad(lambda x, y: x**i * y**j * gaussian(np.array([[x, y]]))[0], ends)[0]

    assert body.mass == pytest.approx(moment(0, 0), rel=1e-12)
    np.testing.assert_allclose(body.first_moment, [moment(1, 0), moment(0, 1)], rtol=1e-12)
    expected = [[moment(2, 0), moment(1, 1)], [moment(1, 1), moment(0, 2)]]
    np.testing.assert_allclose(body.second_moment, expected, rtol=1e-12)


@pytest.mark.parametrize("n", range(1, 5))
def test_independent_gaussians_in_any_dimension(n):
    """∫exp(−x²/2) = √(2π) erf(r/√2) on −r … r, and ∫exp(−x²/2) x² is less by 2 r exp(−r²/2)."""
    body = moments_of_density(lambda x: np.exp(-np.sum((x - 1.0) ** 2, axis=1) / 2), [(-3.0, 5.0)] * n, nodes=22)
    line = np.sqrt(2 * np.pi) * erf(4 / np.sqrt(2))
    assert body.mass == pytest.approx(line**n, rel=1e-10)
    np.testing.assert_allclose(body.centre, np.ones(n), rtol=0, atol=1e-10)
    expected = (1 - 8 * np.exp(-8) / line) * np.eye(n)
    np.testing.assert_allclose(body.central_second_moment / body.mass, expected, rtol=0, atol=1e-10)


def test_a_density_that_jumps_inside_is_refused_and_its_parts_are_exact():
    def step(x):
        return np.where(x[:, 0] < 0.3, 1.0, 4.0)

    with pytest.raises(ParameterError):
        moments_of_density(step, [(0.0, 1.0), (0.0, 1.0)])
    parts = moments_of_density(step, [(0.0, 0.3), (0.0, 1.0)]) + moments_of_density(step, [(0.3, 1.0), (0.0, 1.0)])
    left, right = box(0.3, [0.3, 1.0]), box(2.8, [0.7, 1.0])
    assert_same(parts, left.moved(np.eye(2), [0.15, 0.5]) + right.moved(np.eye(2), [0.65, 0.5]))


def test_a_hollow_ball_turned_and_shifted_by_quadrature_of_its_shells():
    """A thick shell between radii a and b: K = (4π/15)(b⁵ − a⁵) ρ."""
    a, b, rho = 0.6, 1.0, 3.0
    shell = ball(rho * 4 / 3 * np.pi * b**3, b) - ball(rho * 4 / 3 * np.pi * a**3, a)
    np.testing.assert_allclose(
        shell.second_moment, rho * 4 * np.pi / 15 * (b**5 - a**5) * np.eye(3), rtol=1e-14, atol=0
    )


@pytest.mark.parametrize(
    ("build", "name"),
    [
        (lambda: moments_of_points(POINTS, np.ones(5)), "masses"),
        (lambda: moments_of_points(POINTS, [1, 1, 1, 1, 1, -0.25]), "masses"),
        (lambda: moments_of_points(POINTS, np.zeros(6)), "masses"),
        (lambda: moments_of_points(POINTS - np.inf, np.ones(6)), "points"),
        (lambda: moments_on_grid(-np.ones((2, 2)), [0, 0], [1, 1]), "density"),
        (lambda: moments_on_grid(np.ones((2, 2)), [0], [1]), "low"),
        (lambda: moments_on_grid(np.ones((2, 2)), [0, 1], [1, 1]), "limits"),
        (lambda: moments_on_grid(np.ones((2, 0)), [0, 0], [1, 1]), "density"),
        (lambda: moments_on_grid(1.0, [0], [1]), "low"),
        *((lambda given=given: OF_DENSITY(given, [(0, 1)]), "density") for given in (np.ones(4), None, 1.0)),
        (lambda: moments_of_density(gaussian, []), "limits"),
        (lambda: OF_DENSITY(gaussian, 3), "limits"),
        (lambda: OF_DENSITY(gaussian, [[0, 0, 0], [1, 1, 1]]), "limits"),
        (lambda: OF_DENSITY(gaussian, "ab"), "limits"),
        *((lambda nodes=nodes: OF_DENSITY(gaussian, [(0, 1)], nodes), "nodes") for nodes in ("x", [1], 4.5)),
        (lambda: moments_of_density(gaussian, [(0, 1)] * 2, 10**4000), "nodes"),
        (lambda: moments_of_density(gaussian, [(0, 1)], nodes=2), "nodes"),
        (lambda: moments_of_density(gaussian, [(0, 1)] * 6), "nodes"),
        (lambda: moments_of_density(gaussian, [(1, 0)]), "limits"),
        (lambda: moments_of_density(gaussian, [(0, np.inf)]), "limits"),
        (lambda: moments_of_density(lambda x: x[:, 0], [(-1, 1)]), "density"),
        (lambda: moments_of_density(lambda x: 1.0, [(-1, 1)]), "density"),
        (lambda: moments_of_density(lambda x: np.ones(3), [(-1, 1)]), "density"),
        (lambda: moments_of_density(lambda x: np.full(len(x), np.nan), [(-1, 1)]), "density"),
    ],
)
def test_impossible_distributions_are_refused(build, name):
    with pytest.raises(ParameterError) as caught:
        build()
    assert caught.value.name == name
