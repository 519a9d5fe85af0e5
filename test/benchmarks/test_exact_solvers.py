"""The exact solvers of others that are written anew here are theirs: the truth, and what theirs print, is found."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.spatial.transform import Rotation
from scipy.special import elliprj

from peers import frb, theta_series
from peers.elliptic import carlson_rj, third_kind
from peers.task import ATTITUDE, INERTIA, LONG, NS, RATE, SHORT
from peers.truth import errors

pytestmark = pytest.mark.slow  # their loops are compiled anew in each process
MOMENTUM = INERTIA * RATE


def by_frb(t_s, momentum=MOMENTUM, inertia=INERTIA):
    return frb.exact(inertia, momentum, ATTITUDE, t_s)


def by_theta_series(t_s, momentum=MOMENTUM, inertia=INERTIA):
    return theta_series.attitudes(inertia, momentum / inertia, ATTITUDE, t_s)


SOLVERS = pytest.mark.parametrize("solver", [by_frb, by_theta_series])


@SOLVERS
@pytest.mark.parametrize(("task", "limit"), [(SHORT, 2e-14), (LONG, 2e-12)], ids=["short", "long"])
def test_an_exact_solver_finds_the_truth_but_for_the_round_off_of_its_angles(solver, task, limit):
    assert errors(task, solver(task.times_ns / NS)).max() < limit


@pytest.mark.parametrize("momentum", [[1.8, 0.4, -0.9], [-0.3, 0.2, 1.5], [0.1, -1.4, -0.9], [-1.1, -0.2, 0.3]])
def test_both_agree_whichever_axis_the_momentum_circles_about(momentum):
    t_s = np.array([0.1, 3.0, 20.0])
    pairs = (Rotation.from_quat(solver(t_s, np.array(momentum))) for solver in (by_frb, by_theta_series))
    first, second = pairs
    assert (first.inv() * second).magnitude().max() < 1e-13


def test_frb_in_one_call_is_what_its_authors_print():
    # out_example2.dat of algorithm 903, scalar first there
    inertia = np.array([1.0, 1.6487857827119290, 1.9720127096641928])
    momentum = np.array([-0.709894965287627, -0.685144717153487, 0.163174308075589])
    [found] = by_frb(np.array([0.1]), momentum, inertia)
    printed = [-3.5456085277494165e-02, -2.0857297061205097e-02, 3.8941294638131442e-03, 0.9991459727846651]
    np.testing.assert_allclose(found, printed, rtol=0, atol=3e-15)


def test_frb_in_steps_is_what_its_authors_print():
    # out_example4.dat of algorithm 903: after ten steps of 1, with quadrature of order 10
    inertia = np.array([1.0, 1.012686988782515, 3.306237422473038])
    momentum = np.array([-0.544332842491675, 0.729131780907662, -0.414811526666455])
    nodes, weights = np.polynomial.legendre.leggauss(frb.POINTS)
    [found] = frb._one_after_the_other(inertia, momentum, ATTITUDE, np.array([10]), 1.0, nodes, weights)
    printed = np.array([-0.6306293413288832, -0.6127232632258010, 0.3028737154869889, -0.3676198430772359])
    np.testing.assert_allclose(found * np.sign(found @ printed), printed, rtol=0, atol=2e-14)


def test_the_integrals_are_those_of_scipy():
    assert carlson_rj(0.2, 0.5, 1.0, 3.0) == pytest.approx(elliprj(0.2, 0.5, 1.0, 3.0), rel=4e-16)
    n, m = -0.8, 0.6
    for phi in (0.4, 2.0, -7.5):
        value, _ = quad(lambda x: 1 / ((1 - n * np.sin(x) ** 2) * np.sqrt(1 - m * np.sin(x) ** 2)), 0.0, phi)
        assert third_kind(phi, n, m) == pytest.approx(value, abs=1e-10)
