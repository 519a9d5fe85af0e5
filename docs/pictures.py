"""Draw the pictures of paper.md into docs/images: ``python docs/pictures.py``."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from lie_rigid_body import ClosedForm, RigidBody, State
from lie_rigid_body.lie import SO, quaternion
from lie_rigid_body.mechanics import (
    GroupState,
    Lagrangian,
    manakov_integrals,
    mass_matrix,
    momentum_matrix,
    rotation_casimirs,
)
from lie_rigid_body.motion import GroupMovingChart

IMAGES = Path(__file__).parent / "images"
COLOURS = ("#D55E00", "#009E73", "#0072B2", "#CC79A7", "#E69F00", "#56B4E9")


def precession() -> Figure:
    """The axis of a symmetric top goes round its angular momentum on a cone."""
    body, start = RigidBody([1.0, 1.0, 1.8]), State([0, 0, 0, 1], [0.3, 0.5, 1.1])
    t_ns = np.linspace(0, 6e9, 601).astype(np.int64)
    states = ClosedForm(body, start).at(t_ns)
    axis = quaternion.rotate(states.attitude_xyzw, np.array([0.0, 0.0, 1.0]))
    momentum = body.angular_momentum(start)
    momentum = momentum / np.linalg.norm(momentum)
    figure = Figure(figsize=(12.0, 5.2), dpi=120, layout="constrained")
    left, right = figure.add_subplot(1, 2, 1, projection="3d"), figure.add_subplot(1, 2, 2)
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 49), np.linspace(0, np.pi, 25))
    left.plot_surface(
        np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v), color="#C9D6E8", alpha=0.25, linewidth=0, shade=False
    )
    left.plot(*axis.T, color=COLOURS[0], lw=2.2, label="axis of the body")
    left.plot(*np.stack([0 * momentum, 1.25 * momentum]).T, color="black", lw=2.0, label="angular momentum")
    left.plot(*np.stack([0 * axis[0], axis[0]]).T, color=COLOURS[0], lw=1.0, ls="--", label="axis at the start")
    left.set(xlabel="world x", ylabel="world y", zlabel="world z", title="the axis in the world (unit sphere)")
    left.set_box_aspect((1, 1, 1))
    left.legend(loc="upper left", fontsize=9)
    for i, name in enumerate("xyz"):
        right.plot(1e-9 * t_ns, axis[:, i], color=COLOURS[i], label=f"{name} of the axis")
    right.plot(1e-9 * t_ns, axis @ momentum, color="black", ls="--", label="cosine of its angle to L")
    right.set(xlabel="time [s]", ylabel="component", title="inertia 1, 1, 1.8 kg m²; body rate 0.3, 0.5, 1.1 rad/s")
    right.grid(alpha=0.3)
    right.legend(fontsize=9, loc="lower right")
    return figure


def so4() -> Figure:
    """A body in four dimensions: six rates that change, four integrals that do not."""
    group, moment = SO(4), np.diag([0.2, 0.3, 0.5, 0.7])
    lagrangian = Lagrangian(group, mass_matrix(moment, group.generators))
    start = GroupState(group.identity, np.array([0.9, 0.2, -0.5, 0.4, 0.7, -0.3]))
    t_ns = np.linspace(0, 60e9, 1201).astype(np.int64)
    states = GroupMovingChart(lagrangian, start, max_step=0.005).at(t_ns)
    p = momentum_matrix(group, lagrangian.momenta(states.rate))
    figure = Figure(figsize=(12.0, 6.4), dpi=120, layout="constrained")
    rates, drifts = figure.subplots(2, 1, sharex=True)
    for i in range(6):
        a, b = np.argwhere(group.generators[i] > 0)[0]
        rates.plot(1e-9 * t_ns, states.rate[:, i], color=COLOURS[i], label=f"plane {min(a, b) + 1}{max(a, b) + 1}")
    rates.set(ylabel="body rate [rad/s]", title="a free body on SO(4), K = diag(0.2, 0.3, 0.5, 0.7) kg m²")
    rates.legend(ncols=6, loc="upper center", fontsize=9)
    names = ["tr P²", "tr(P + λK²)³: λ", "tr(P + λK²)⁴: λ²", "tr P⁴"]
    for i, values in enumerate(manakov_integrals(p, moment).T):
        drifts.plot(1e-9 * t_ns, values / values[0] - 1.0, color=COLOURS[i], lw=1.0, label=names[i])
    pfaffian = rotation_casimirs(p)[:, -1]
    drifts.plot(1e-9 * t_ns, pfaffian / pfaffian[0] - 1.0, color="black", lw=1.0, label="Pfaffian of P")
    drifts.set(xlabel="time [s]", ylabel="relative change of\nManakov's integrals and the Pfaffian")
    drifts.legend(ncols=5, loc="upper center", bbox_to_anchor=(0.5, 1.16), frameon=False, fontsize=9)
    for axes in (rates, drifts):
        axes.grid(alpha=0.3)
        axes.margins(x=0)
    return figure


def symmetric_top() -> Figure:
    """The momentum along the axis of a symmetric top is conserved in the body frame, the others are not."""
    body, start = RigidBody([1.0, 1.0, 1.8]), State([0, 0, 0, 1], [0.3, 0.5, 1.1])
    t_ns = np.linspace(0, 15e9, 901).astype(np.int64)
    momenta = body.body_momentum(ClosedForm(body, start).at(t_ns))
    figure = Figure(figsize=(12.0, 3.6), dpi=120, layout="constrained")
    axes = figure.subplots()
    for i, label in enumerate((r"$p_1$", r"$p_2$", r"$p_3$, along the axis")):
        axes.plot(1e-9 * t_ns, momenta[:, i], color=COLOURS[i], lw=1.8, label=label)
    axes.set(xlabel="time [s]", ylabel="body momentum [kg m²/s]", title="inertia 1, 1, 1.8 kg m²")
    axes.grid(alpha=0.3)
    axes.margins(x=0)
    axes.legend(loc="center right")
    return figure


def main() -> None:
    """Write every picture."""
    IMAGES.mkdir(exist_ok=True)
    for draw in (precession, so4, symmetric_top):
        draw().savefig(IMAGES / f"{draw.__name__}.png")


if __name__ == "__main__":
    main()
