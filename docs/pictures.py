"""Draw the pictures of paper.md, and the first one of the README, into docs/images: ``python docs/pictures.py``."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Final

import numpy as np
from matplotlib.figure import Figure

from lie_rigid_body import ClosedForm, MovingChart, RigidBody, State
from lie_rigid_body.certificate.segments import recorded_segments
from lie_rigid_body.cli.figure import draw
from lie_rigid_body.cli.record import main as record
from lie_rigid_body.groups import (
    SO,
    GroupMovingChart,
    GroupState,
    Lagrangian,
    manakov_integrals,
    mass_matrix,
    momentum_matrix,
    rotation_casimirs,
)
from lie_rigid_body.lie import quaternion
from lie_rigid_body.recording.bag_reader import read_bag

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from mpl_toolkits.mplot3d import Axes3D

IMAGES: Final = Path(__file__).parent / "images"

EPSILON: Final = float(np.finfo(np.float64).eps)

COMPONENTS: Final = ("#D55E00", "#009E73", "#0072B2", "#CC79A7", "#E69F00", "#56B4E9")
"""One colour for each component of a vector. What is no component is drawn in none of them."""

INTEGRALS: Final = (("#332288", "-"), ("#882255", "--"), ("#8B5A2B", "-."), ("#808000", ":"), ("black", "-"))
BODY_AXIS: Final = "#6A3D9A"
MOMENTUM: Final = "black"
COSINE: Final = "#555555"

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


def _finish(axes: Axes, columns: int) -> None:
    """A grid, and the legend above the curves and not on them."""
    axes.grid(alpha=0.3)
    axes.margins(x=0)
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=columns, frameon=False, fontsize=9)


def main() -> None:
    """Write every picture."""
    IMAGES.mkdir(exist_ok=True)
    for picture in (dzhanibekov, precession, so4, symmetric_top):
        picture().savefig(IMAGES / f"{picture.__name__}.png")


if __name__ == "__main__":
    main()
