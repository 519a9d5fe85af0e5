"""Closed forms of homogeneous bodies, against quadrature that knows nothing of them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp, quad
from scipy.integrate import nquad

from lie_rigid_body import RigidBody
from lie_rigid_body.mechanics import ball, box, cylinder, disc, ellipsoid, rod
from lie_rigid_body.mechanics.shapes import MIN_THICKNESS, box_sides

DIMENSIONS = range(1, 7)


def ellipse_limits(semi_axes):
    """Limits of each coordinate given the earlier ones, as scipy's nquad wants them: innermost coordinate first."""

    def limit(k):
        def ends(*earlier):
            rest = 1.0 - sum((x / a) ** 2 for x, a in zip(earlier, semi_axes[k + 1 :], strict=True))
            reach = semi_axes[k] * np.sqrt(max(rest, 0.0))
            return -reach, reach

        return ends

    return [limit(k) for k in range(len(semi_axes))]


def mean_products(limits):
    """Mean of xᵢxⱼ over a region by scipy's nested adaptive quadrature."""
    n = len(limits)
    volume = nquad(lambda *x: 1.0, limits)[0]
    return np.array([[nquad(lambda *x: x[i] * x[j], limits)[0] / volume for j in range(n)] for i in range(n)])  # noqa: B023


@pytest.mark.parametrize("semi_axes", [[0.7], [1.3, 0.4], [0.5, 1.1, 2.0]])
def test_ellipsoid_by_nested_quadrature(semi_axes):
    expected = 2.5 * mean_products(ellipse_limits(semi_axes))
    body = ellipsoid(2.5, semi_axes)
    np.testing.assert_allclose(body.second_moment, expected, rtol=0, atol=1e-7)
    assert body.mass == 2.5
    np.testing.assert_array_equal(body.centre, np.zeros(len(semi_axes)))


@pytest.mark.parametrize("n", DIMENSIONS)
def test_ball_by_slices(n):
    """A slice at height x of the unit ball has a volume proportional to (1 − x²)^((n−1)/2)."""
    with mp.workdps(30):
        weight = lambda x: (1 - x * x) ** (mp.mpf(n - 1) / 2)  # noqa: E731
        mean_square = quad(lambda x: x * x * weight(x), [-1, 0, 1]) / quad(weight, [-1, 0, 1])
    body = ball(3.0, 1.7, n)
    np.testing.assert_allclose(body.second_moment, 3.0 * 1.7**2 * float(mean_square) * np.eye(n), rtol=1e-14, atol=0)


@pytest.mark.parametrize("n", DIMENSIONS)
def test_box_by_its_edges(n):
    """Coordinates are independent in a box: the mean of xᵢ² is that over one edge."""
    edges = 0.3 + np.arange(n)
    with mp.workdps(30):
        mean_squares = [float(quad(lambda x: x * x, [-mp.mpf(e) / 2, mp.mpf(e) / 2]) / mp.mpf(e)) for e in edges]
    np.testing.assert_allclose(box(4.0, edges).second_moment, 4.0 * np.diag(mean_squares), rtol=1e-14, atol=0)


def test_cylinder_by_nested_quadrature():
    r, h = 0.8, 1.5
    expected = 3.0 * mean_products(cylinder_limits(r, h))
    np.testing.assert_allclose(cylinder(3.0, r, h).second_moment, expected, rtol=0, atol=1e-7)


def cylinder_limits(r, h):
    def x_ends(y, z):
        reach = np.sqrt(max(r * r - y * y, 0.0))
        return -reach, reach

    return [x_ends, lambda z: (-r, r), lambda: (-h / 2, h / 2)]


def test_disc_and_rod_are_the_limits_of_a_cylinder():
    thin = cylinder(3.0, 0.8, 1e-9)
    np.testing.assert_allclose(disc(3.0, 0.8).second_moment, thin.second_moment, rtol=0, atol=1e-17)
    slender = cylinder(3.0, 1e-9, 0.8)
    np.testing.assert_allclose(rod(3.0, 0.8).second_moment, slender.second_moment, rtol=0, atol=1e-17)


def test_disc_by_quadrature_in_its_plane():
    expected = np.zeros((3, 3))
    expected[:2, :2] = 2.0 * mean_products(ellipse_limits([0.6, 0.6]))
    np.testing.assert_allclose(disc(2.0, 0.6).second_moment, expected, rtol=0, atol=1e-7)


def test_a_stack_of_discs_is_a_cylinder_and_a_stack_of_rods_a_box():
    count, r, h = 200, 0.5, 1.2
    heights = (np.arange(count) + 0.5) / count * h - h / 2
    stack = sum_of(disc(1.0 / count, r).about([0.0, 0.0, -z]) for z in heights)
    # midpoint sums miss h²/(12 N²)
    expected = cylinder(1.0, r, h).second_moment - np.diag([0, 0, h**2 / count**2 / 12])
    np.testing.assert_allclose(stack.second_moment, expected, rtol=0, atol=1e-15)
    fence = sum_of(rod(1.0 / count, r).about([-z, 0.0, 0.0]) for z in heights)
    expected = box(1.0, [h, 1e-12, r]).second_moment - np.diag([h**2 / count**2 / 12, 0, 0])
    np.testing.assert_allclose(fence.second_moment, expected, rtol=0, atol=1e-15)


def sum_of(bodies):
    bodies = list(bodies)
    total = bodies[0]
    for body in bodies[1:]:
        total = total + body
    return total


@pytest.mark.parametrize(
    ("body", "moments"),
    [
        (ball(5.0, 2.0), [8.0, 8.0, 8.0]),
        (box(12.0, [1.0, 2.0, 3.0]), [13.0, 10.0, 5.0]),
        (ellipsoid(5.0, [1.0, 2.0, 3.0]), [13.0, 10.0, 5.0]),
        (cylinder(12.0, 2.0, 3.0), [21.0, 21.0, 24.0]),
        (disc(4.0, 1.0), [1.0, 1.0, 2.0]),
    ],
)
def test_inertias_of_textbooks(body, moments):
    """2/5 m r², m (b² + c²)/12, m (b² + c²)/5, m (3 r² + h²)/12 and m r²/2, m r²/4 and m r²/2."""
    found = RigidBody.from_second_moment(body.second_moment).inertia
    np.testing.assert_allclose(found, np.diag(moments), rtol=1e-15, atol=0)


sides = st.floats(0.05, 1.0)


@given(sides, sides, sides)
def test_the_box_to_draw_has_the_moments_of_the_body(a, b, c):
    moments = np.sort([b * b + c * c, a * a + c * c, a * a + b * b])
    # rising moments: the longest side comes first
    expected = np.sort([a, b, c])[::-1] / max(a, b, c)
    np.testing.assert_allclose(box_sides(moments), expected, rtol=0, atol=1e-6)


def test_a_flat_body_and_a_rod_can_be_seen():
    np.testing.assert_allclose(box_sides([1.0, 1.0, 2.0]), [1.0, 1.0, MIN_THICKNESS])
    np.testing.assert_allclose(box_sides([1e-9, 1.0, 1.0]), [1.0, MIN_THICKNESS, MIN_THICKNESS], rtol=1e-3)
