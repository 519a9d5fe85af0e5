"""Draw the pictures of paper.md, of the README and of the first page into docs/images: ``python docs/pictures.py``."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Final

import numpy as np
from matplotlib.colors import hsv_to_rgb
from matplotlib.figure import Figure
from scipy.spatial.transform import Rotation

from lie_rigid_body import ClosedForm, MovingChart, RigidBody, State, simulate
from lie_rigid_body.cli.record import main as record
from lie_rigid_body.groups import (
    SO,
    SU,
    GroupMovingChart,
    GroupState,
    Lagrangian,
    MatrixLieGroup,
    chart_reach,
    double_cover,
    manakov_integrals,
    mass_matrix,
    momentum_matrix,
    rotation_casimirs,
)
from lie_rigid_body.lie import quaternion
from lie_rigid_body.recording.bag_reader import read_bag
from lie_rigid_body.report import write_plot
from lie_rigid_body.report.recorded_motion import recorded_segments
from lie_rigid_body.report.recording_picture import draw

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.axes import Axes
    from mpl_toolkits.mplot3d import Axes3D

    from lie_rigid_body.evaluation import Score

IMAGES: Final = Path(__file__).parent / "images"

EPSILON: Final = float(np.finfo(np.float64).eps)

COMPONENTS: Final = ("#D55E00", "#009E73", "#0072B2", "#CC79A7", "#E69F00", "#56B4E9")
"""One colour for each component of a vector. What is no component is drawn in none of them."""

INTEGRALS: Final = (("#332288", "-"), ("#882255", "--"), ("#8B5A2B", "-."), ("#808000", ":"), ("black", "-"))
BODY_AXIS: Final = "#6A3D9A"
MOMENTUM: Final = "black"
COSINE: Final = "#555555"
PATH: Final = "#0072B2"
OTHER_PATH: Final = "#D55E00"
LIMIT: Final = "#882255"

TOP: Final = RigidBody([1.0, 1.0, 1.8])
TOP_START: Final = State([0, 0, 0, 1], [0.7, 0.9, 1.0])
TOP_CAPTION: Final = "symmetric top, inertia 1, 1, 1.8 kg m², body rate at the start 0.7, 0.9, 1 rad/s"


def precession() -> Figure:
    """The axis of a symmetric top goes round its angular momentum on a cone."""
    t_ns = np.linspace(0, 6e9, 601).astype(np.int64)
    states = ClosedForm(TOP, TOP_START).at(t_ns)
    axis = quaternion.rotate(states.attitude_xyzw, np.array([0.0, 0.0, 1.0]))
    momentum = TOP.angular_momentum(TOP_START)
    momentum = momentum / np.linalg.norm(momentum)
    figure = Figure(figsize=(12.0, 5.6), dpi=120, layout="constrained")
    figure.suptitle(TOP_CAPTION)
    grid = figure.add_gridspec(1, 2, width_ratios=(1.0, 1.25), wspace=0.08)
    _draw_cone(figure.add_subplot(grid[0], projection="3d"), axis, momentum)
    right = figure.add_subplot(grid[1])
    for i, name in enumerate("xyz"):
        right.plot(1e-9 * t_ns, axis[:, i], color=COMPONENTS[i], lw=1.8, label=f"{name} of the axis")
    right.plot(1e-9 * t_ns, axis @ momentum, color=COSINE, lw=1.8, ls="--", label="cosine of its angle to L")
    right.set(xlabel="time [s]", ylabel="axis of the body in the world")
    _finish(right, columns=4)
    return figure


def _draw_cone(axes: Axes3D, axis: np.ndarray, momentum: np.ndarray) -> None:
    """The path of the axis on the unit sphere."""
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 49), np.linspace(0, np.pi, 25))
    sphere = np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)
    axes.plot_surface(*sphere, color="#C9D6E8", alpha=0.25, linewidth=0, shade=False)
    for spoke in axis[::12]:
        axes.plot(*np.stack([0 * spoke, spoke]).T, color=BODY_AXIS, lw=0.6, alpha=0.25)
    axes.plot(*np.stack([0 * momentum, 1.3 * momentum]).T, color=MOMENTUM, lw=2.0, label="direction of L")
    axes.plot(*axis.T, color=BODY_AXIS, lw=2.2, label="axis of the body")
    axes.plot(*np.stack([0 * axis[0], axis[0]]).T, color=BODY_AXIS, lw=1.4, ls="--", label="at the start")
    ticks = (-1.0, 0.0, 1.0)
    axes.set(xticks=ticks, yticks=ticks, zticks=ticks, xlabel="world x", ylabel="world y", zlabel="world z")
    axes.set_box_aspect((1, 1, 1), zoom=0.97)
    axes.view_init(elev=24.0, azim=-52.0)
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, frameon=False, fontsize=9)


def so4() -> Figure:
    """A body in four dimensions: six rates that change, four integrals that do not."""
    group, moment = SO(4), np.diag([0.2, 0.3, 0.5, 0.7])
    lagrangian = Lagrangian(group, mass_matrix(moment, group.generators))
    start = GroupState(group.identity, np.array([0.9, 0.2, -0.5, 0.4, 0.7, -0.3]))
    t_ns = np.linspace(0, 60e9, 1201).astype(np.int64)
    states = GroupMovingChart(lagrangian, start, max_step=0.002).at(t_ns)
    figure = Figure(figsize=(12.0, 6.8), dpi=120, layout="constrained")
    figure.suptitle("free body on SO(4), K = diag(0.2, 0.3, 0.5, 0.7) kg m², moving chart rkmk4, step 2 ms")
    rates, drifts = figure.subplots(2, 1, sharex=True, height_ratios=(1.6, 1.0))
    for i, generator in enumerate(group.generators):
        a, b = sorted(np.argwhere(generator > 0)[0] + 1)
        rates.plot(1e-9 * t_ns, states.rate[:, i], color=COMPONENTS[i], lw=1.6, label=f"plane {a}{b}")
    rates.set_ylabel("body rate [rad/s]")
    _finish(rates, columns=6)
    _draw_drifts(drifts, 1e-9 * t_ns, momentum_matrix(group, lagrangian.momenta(states.rate)), moment)
    return figure


def _draw_drifts(axes: Axes, t: np.ndarray, p: np.ndarray, moment: np.ndarray) -> None:
    """Manakov's integrals and the Pfaffian, each relative to itself, beside the spacing of doubles."""
    names = ("tr P²", "tr(P + λK²)³ at λ", "tr(P + λK²)⁴ at λ²", "tr P⁴", "Pfaffian of P")
    values = np.column_stack([manakov_integrals(p, moment), rotation_casimirs(p)[:, -1]])
    changes = values / values[0] - 1.0
    for name, change, (colour, style) in zip(names, changes.T, INTEGRALS, strict=True):
        axes.plot(t, change, color=colour, ls=style, lw=1.3, label=name)
    axes.axhspan(-EPSILON, EPSILON, color="0.85", lw=0, label="spacing of doubles")
    axes.set(xlabel="time [s]", ylabel="change since the start,\nrelative to the integral")
    _finish(axes, columns=6)


def dzhanibekov() -> Figure:
    """What `plot` draws of the scenario at its defaults."""
    with TemporaryDirectory() as folder:
        bag = f"{folder}/flips.mcap"
        record([bag, "--scenario", "dzhanibekov", "--duration", "60", "--quiet"])
        return draw(recorded_segments(read_bag(bag)))


def first_score() -> Score:
    """The score of the filter of docs/tutorials/first_filter.md, which takes magnetic north for north."""
    run = simulate(
        "tumbling_cubesat",
        duration=60.0,
        imu_rate=100.0,
        magnetometer_rate=100.0,
        accelerometer_mode="pivot_gravity",
        sensor_grade="mems",
    )
    assert run.imu is not None
    assert run.magnetometer is not None
    rows = zip(run.imu.specific_force, run.magnetometer.field, strict=True)
    world = [[0.0, 0.0, 1.0], [0.0, 21.0e-6, -43.5e-6]]
    return run.score(np.array([Rotation.align_vectors(world, row)[0].as_quat() for row in rows]))


def symmetric_top() -> Figure:
    """The momentum along the axis of a symmetric top is conserved in the body frame, the others are not."""
    t_ns = np.linspace(0, 15e9, 901).astype(np.int64)
    momenta = TOP.body_momentum(MovingChart(TOP, TOP_START).at(t_ns))
    figure = Figure(figsize=(12.0, 4.2), dpi=120, layout="constrained")
    figure.suptitle(TOP_CAPTION)
    axes = figure.subplots()
    for i, label in enumerate((r"$p_1$", r"$p_2$", r"$p_3$, along the axis: conserved")):
        axes.plot(1e-9 * t_ns, momenta[:, i], color=COMPONENTS[i], lw=1.8, label=label)
    axes.set(ylim=(-1.4, 2.1), xlabel="time [s]", ylabel="momentum in the body frame [kg m²/s]")
    _finish(axes, columns=3)
    return figure


def chart_reaches() -> Figure:
    """What a chart that stays makes of a motion, what one that moves does, and where charts of two groups end."""
    figure = Figure(figsize=(12.0, 7.6), dpi=120, layout="constrained")
    (still, so3), (moving, su2) = figure.subplots(2, 2)
    t_ns = np.linspace(0, 12e9, 2401).astype(np.int64)
    motion = MovingChart(RigidBody([1.0, 2.0, 2.9]), State([0, 0, 0, 1], [0.5, 0.8, 0.2])).at(t_ns)
    q, every = motion.attitude_xyzw, 100
    centres = q[np.arange(len(q)) // every * every]
    _draw_coordinates(still, t_ns, np.tile(q[0], (len(q), 1)), q, "one chart, about the start: jumps by 2π")
    _draw_coordinates(moving, t_ns, centres, q, "charts re-centred every half second: never far from 0")
    moving.set_xlabel("time [s]")
    _draw_reach(so3, SO(3), "SO(3)")
    _draw_reach(su2, SU(2), "its cover SU(2)")
    su2.set_xlabel("turn about an axis [rad]")
    return figure


def _draw_coordinates(axes: Axes, t_ns: np.ndarray, centres: np.ndarray, q: np.ndarray, title: str) -> None:
    """The rotation vectors from the centres of charts to attitudes, broken where they jump."""
    beta = quaternion.log(quaternion.multiply(quaternion.conjugate(centres), q))
    breaks = np.linalg.norm(np.diff(beta, axis=0), axis=1) > 0.1
    beta[1:][breaks] = np.nan
    for i, label in enumerate((r"$\beta^1$", r"$\beta^2$", r"$\beta^3$")):
        axes.plot(1e-9 * t_ns, beta[:, i], color=COMPONENTS[i], lw=1.6, label=label)
    axes.set(ylim=(-3.6, 4.8), ylabel="chart coordinates [rad]", title=title)
    axes.set_yticks([-np.pi, 0, np.pi], ["−π", "0", "π"])
    axes.grid(alpha=0.3)
    axes.margins(x=0)
    axes.legend(loc="upper left", ncols=3, fontsize=9)


def _draw_reach(axes: Axes, group: MatrixLieGroup, title: str) -> None:
    """The logarithm of a turn, and what dexp leaves of the weakest direction."""
    turns = np.linspace(1e-3, 2.3 * np.pi, 600)
    turns = turns[np.abs(np.sin(0.5 * turns)) > 1e-3]
    xi = np.outer(turns, [0.0, 0.0, 1.0])
    back = np.linalg.norm(group.log(group.exp(xi)), axis=1)
    weakest = np.linalg.svd(group.dexp(xi), compute_uv=False)[:, -1]
    axes.plot(turns, back, color=PATH, lw=1.8, label="length of log exp, rad")
    axes.plot(turns, np.pi * weakest, color=OTHER_PATH, lw=1.8, ls="--", label="π × smallest singular value of dexp")
    reach = chart_reach(group, [0.0, 0.0, 1.0])
    for x, y, text in _ends(float(reach.one_to_one), float(reach.regular)):
        axes.axvline(x, color=LIMIT, lw=1.2, ls=":")
        axes.text(x + 0.06, y, text, rotation=90, ha="left", va="top", color=LIMIT, fontsize=10)
    axes.set(ylim=(0, 8.9), title=f"reach of a chart of {title}")
    axes.set_xticks([0, np.pi, 2 * np.pi], ["0", "π", "2π"])
    axes.set_yticks([0, np.pi, 2 * np.pi], ["0", "π", "2π"])
    axes.grid(alpha=0.3)
    axes.margins(x=0)
    axes.legend(loc="upper left", fontsize=9)


def _ends(one_to_one: float, regular: float) -> list[tuple[float, float, str]]:
    """Where a chart ends, and a label beside it, clear of the curves."""
    if one_to_one == regular:
        return [(regular, 4.8, "not unique, rank lost")]
    return [(one_to_one, 6.6, "no longer unique"), (regular, 6.6, "rank lost")]


def double_cover_turns() -> Figure:
    """Two full turns: the rotation closes after each, its lift to SU(2) after both, and so does a spinor."""
    angle = np.linspace(0, 4 * np.pi, 801)
    lifted = double_cover.lift(SO(3).exp(np.outer(angle, [0.0, 0.0, 1.0])))
    q = double_cover.to_quaternion(lifted)
    spinor = np.array([0.6, 0.8j])
    figure = Figure(figsize=(12.0, 4.4), dpi=120, layout="constrained")
    left, right = figure.subplots(1, 2)
    left.plot(angle, np.cos(angle), color=COSINE, lw=1.8, ls="--", label="R₁₁ of the rotation")
    left.plot(angle, q[:, 3], color=PATH, lw=1.8, label="w of its lift")
    left.plot(angle, q[:, 2], color=OTHER_PATH, lw=1.8, label="z of its lift")
    left.set(ylabel="entry of the matrix, of the quaternion")
    together = np.linalg.norm(spinor + lifted @ spinor, axis=1) ** 2
    right.plot(angle, together, color=PATH, lw=1.8, label="a turned spinor, added to one that is not")
    right.set(ylabel="intensity, 1 for one of them")
    for axes in (left, right):
        axes.set_xlabel("turn about the z axis")
        axes.set_xticks(np.pi * np.arange(5), ["0", "π", "2π", "3π", "4π"])
        _finish(axes, columns=3)
    return figure


def nearby_paths() -> Figure:
    """The action of paths near a motion, near a path that is none, and near geodesics short and long."""
    figure = Figure(figsize=(12.0, 4.8), dpi=120, layout="constrained")
    left, right = figure.subplots(1, 2)
    body, h = Lagrangian(SO(3), np.diag([1.0, 2.0, 2.9])), 5e-3
    t = h * np.arange(201)
    rate = np.array([0.9, 1.4, -0.6])
    start = GroupState(np.eye(3), rate)
    motion = GroupMovingChart(body, start, max_step=h).at(np.rint(1e9 * t).astype(np.int64)).element
    steady = SO(3).exp(np.outer(t, rate))
    eta = np.outer(np.sin(np.pi * t), body.momentum_rate(rate))
    near_motion, near_steady = (_action_changes(body, path, eta, h) for path in (motion, steady))
    _draw_actions(left, (near_motion, "near the motion"), (near_steady, "near a path of constant rate"))
    left.set_title("free body on SO(3), one second")
    even = Lagrangian(SO(3), np.eye(3))
    _draw_actions(
        right, (_geodesic_changes(even, 0.8), "turn of 0.8 · 2π"), (_geodesic_changes(even, 1.2), "turn of 1.2 · 2π")
    )
    right.set_title("spin of a sphere, before and beyond its conjugate point")
    return figure


SIZES: Final = np.linspace(-0.3, 0.3, 41)
"""Sizes ε of the variations."""


def _action_changes(body: Lagrangian, path: np.ndarray, eta: np.ndarray, step: float) -> np.ndarray:
    """The action of path · exp(ε hat η) less that of the path, for all sizes ε."""
    group = body.group
    return np.array([body.action(path @ group.exp(size * eta), step) for size in SIZES]) - body.action(path, step)


def _geodesic_changes(even: Lagrangian, turns: float) -> np.ndarray:
    s = np.linspace(0, 2 * np.pi * turns, 201)
    bump = np.sin(np.pi * s / s[-1])
    eta = np.stack([bump * np.cos(s / 2), -bump * np.sin(s / 2), 0 * s], axis=1)
    return _action_changes(even, SO(3).exp(np.outer(s, [0.0, 0.0, 1.0])), eta, float(s[1]))


def _draw_actions(axes: Axes, first: tuple[np.ndarray, str], second: tuple[np.ndarray, str]) -> None:
    for (change, label), colour, style in zip((first, second), (PATH, OTHER_PATH), ("-", "--"), strict=True):
        axes.plot(SIZES, change, color=colour, lw=1.8, ls=style, label=label)
    axes.plot(0, 0, "o", color=MOMENTUM, ms=5)
    axes.set(xlabel="size ε of the variation", ylabel="action, less that of the path [J s]")
    axes.grid(alpha=0.3)
    axes.margins(x=0)
    axes.legend(loc="upper center", fontsize=9)


def geodesics() -> Figure:
    """Geodesics of two metrics on SO(3), in the chart about their start: straight, and not."""
    figure = Figure(figsize=(12.0, 5.8), dpi=120, layout="constrained")
    left, right = (figure.add_subplot(1, 2, place, projection="3d") for place in (1, 2))
    _draw_geodesics(left, RigidBody([2.0, 2.0, 2.0]))
    left.set_title("round metric, M = diag(2, 2, 2): straight lines")
    _draw_geodesics(right, RigidBody([1.0, 2.0, 2.9]))
    right.set_title("uneven metric, M = diag(1, 2, 2.9)")
    return figure


def _draw_geodesics(axes: Axes3D, body: RigidBody) -> None:
    """Motions from one attitude at one energy, with rates in the plane of the axes 1 and 3, up to a half turn."""
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 49), np.linspace(0, np.pi, 25))
    ball = np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)
    axes.plot_surface(*(np.pi * x for x in ball), color="#C9D6E8", alpha=0.18, linewidth=0, shade=False)
    t_ns = np.linspace(0, 6e9, 301).astype(np.int64)
    for angle in np.linspace(0, 2 * np.pi, 24, endpoint=False):
        direction = np.array([np.cos(angle), 0.0, np.sin(angle)])
        rate = direction / np.sqrt(direction @ body.inertia @ direction)
        beta = quaternion.log(MovingChart(body, State([0, 0, 0, 1], rate)).at(t_ns).attitude_xyzw)
        end = np.argmax(np.linalg.norm(np.diff(beta, axis=0), axis=1) > 1.0) or len(beta) - 1
        axes.plot(*beta[: end + 1].T, color=hsv_to_rgb((angle / (2 * np.pi), 0.85, 0.75)), lw=1.6)
    ticks = ([-np.pi, 0, np.pi], ["−π", "0", "π"])
    for set_ticks in (axes.set_xticks, axes.set_yticks, axes.set_zticks):
        set_ticks(*ticks)
    axes.set(xlabel=r"$\beta^1$", ylabel=r"$\beta^2$", zlabel=r"$\beta^3$")
    axes.set_box_aspect((1, 1, 1), zoom=1.05)
    axes.view_init(elev=22.0, azim=-62.0)


def _finish(axes: Axes, columns: int) -> None:
    """A grid, and the legend above the curves and not on them."""
    axes.grid(alpha=0.3)
    axes.margins(x=0)
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=columns, frameon=False, fontsize=9)


PICTURES: Final[dict[str, Callable[[], Figure]]] = {
    "precession": precession,
    "so4": so4,
    "symmetric_top": symmetric_top,
    "chart_reach": chart_reaches,
    "double_cover": double_cover_turns,
    "nearby_paths": nearby_paths,
    "geodesics": geodesics,
}


def main() -> None:
    """Write every picture."""
    IMAGES.mkdir(exist_ok=True)
    for name, picture in PICTURES.items():
        picture().savefig(IMAGES / f"{name}.png")
    write_plot(first_score(), IMAGES / "first_filter.png", title="the first filter", overwrite=True)


if __name__ == "__main__":
    main()
