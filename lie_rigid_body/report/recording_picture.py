"""The picture of a recording: body rate, position, drift of energy and momentum, and the polhode of an arc."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure
from mpl_toolkits.mplot3d.axes3d import Axes3D

from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.foundation.errors import BagError
from lie_rigid_body.foundation.wording import counted
from lie_rigid_body.report.drawing import COLOURS, FRAME, GREY, RED, SURFACE, draw_curve, finish
from lie_rigid_body.report.recorded_motion import (
    EYE,
    POLHODE_POINTS,
    VIEW,
    Ellipsoid,
    Pieces,
    RecordedSegment,
    in_words,
    times,
)
from lie_rigid_body.scenario.arcs import arc_changes, largest_of_arcs
from lie_rigid_body.scenario.facts import facts

_TICK_PAD = 5.0
_LABEL_PAD = 11.0
"""Distances of numbers and label from an axis, points."""


@np.errstate(all="ignore")  # recorded numbers may be anything
def draw(pieces: Pieces) -> Figure:
    """Draw a recording.

    Parameters
    ----------
    pieces : sequence of RecordedSegment
        Those without a sample that has both pose and twist are left out.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    BagError
        If none is left.
    """
    pieces = [piece for piece in pieces if len(piece.samples)]
    if not pieces:
        raise BagError("no sample has both a pose and a twist of the same stamp: record both topics together")
    figure = Figure(figsize=(13.0, 7.6), dpi=120, layout="constrained")
    over_time, of_space = cast(Any, figure.subfigures(1, 2, width_ratios=(1.25, 1.0), wspace=0.05))
    whose = "first segment: " if len(pieces) > 1 else ""
    of_arc = "first moving arc: " if pieces[0].segment.scenario.kicks else ""
    _draw_curves(over_time, pieces)
    _draw_polhode(of_space, pieces[0], whose + of_arc)
    figure.suptitle(_title(pieces, whose), fontsize=11)
    return figure


def curves(pieces: Pieces) -> Figure:
    """Figure of the curves alone, half a page wide."""
    figure = Figure(figsize=(5.6, 7.5), layout="constrained")
    _draw_curves(figure, pieces)
    return figure


def _draw_curves(figure: Any, pieces: Pieces) -> None:
    scenarios = [piece.segment.scenario for piece in pieces]
    moves = any(scenario.moves for scenario in scenarios)
    drifts = 2 * any(scenario.motion != "path" for scenario in scenarios)
    heights = (1.35, *[1.0] * (moves + drifts))
    panels = figure.subplots(len(heights), 1, sharex=True, height_ratios=heights)
    rate, *others = panels
    _draw_vectors(rate, pieces, lambda piece: piece.states.body_rate, r"\omega", "body rate [rad/s]")
    if moves:
        _draw_vectors(others[0], pieces, lambda piece: piece.position, "", "position [m]")
    if drifts:
        _draw_drifts(others[-2], others[-1], pieces)
    others[-1].set_xlabel("time since the first sample [s]")
    for axes in panels:
        finish(axes, 3)
        axes.margins(x=0.0)
        axes.label_outer()
        draw_resets(axes, pieces)


def draw_resets(axes: Axes, pieces: Pieces) -> None:
    """Draw a mark at the upper edge for each reset."""
    starts = np.array([piece.segment.start_ns for piece in pieces[1:]], dtype=np.int64)
    axes.vlines(times(starts, pieces), 0.92, 1.0, transform=axes.get_xaxis_transform(), color="black", lw=0.8)


def _draw_vectors(axes: Axes, pieces: Pieces, of: Callable[[RecordedSegment], Array], symbol: str, label: str) -> None:
    for piece in pieces:
        t = times(piece.stamps_ns, pieces)
        for name, colour, values in zip("xyz", COLOURS, of(piece).T, strict=True):
            component = f"${symbol}_{name}$" if symbol else f"${name}$"
            draw_curve(axes, t, values, colour, component if piece is pieces[0] else None, 1.4)
    axes.set_ylabel(label)


def _draw_drifts(energy: Axes, momentum: Axes, pieces: Pieces) -> None:
    """Draw relative changes of kinetic energy and world momentum since the start, or since the latest kick."""
    t = np.concatenate([times(piece.stamps_ns, pieces) for piece in pieces])
    drifts = np.concatenate([_drifts(piece) for piece in pieces])
    draw_curve(energy, t, drifts[:, 0], GREY, None, 0.6)
    for name, colour, drift in zip("xyz", COLOURS, drifts[:, 1:].T, strict=True):
        draw_curve(momentum, t, drift, colour, rf"$L_{name}$", 0.6, alpha=0.6)
    energy.set_ylabel("energy drift\n$(H - H_0)/H_{max}$")
    momentum.set_ylabel("world momentum drift\n$(L - L_0)/|L|_{max}$")


def _drifts(piece: RecordedSegment) -> Array:
    """Changes of energy and world momentum since the begin of the arc over the largest, shape (N, 4); NaN on a path."""
    scenario = piece.segment.scenario
    if scenario.path():
        return np.full((len(piece.samples), 4), np.nan)
    changes = arc_changes(scenario, piece.stamps_ns - piece.segment.start_ns, piece.states)
    return np.hstack(
        [change / (size or 1.0) for (change, _), size in zip(changes, largest_of_arcs(scenario), strict=True)]
    )


def polhode(piece: RecordedSegment) -> Figure:
    """Figure of the polhode alone."""
    figure = Figure(figsize=(5.0, 5.0), layout="constrained")
    _draw_polhode(figure, piece, "")
    return figure


def _draw_polhode(figure: Figure | SubFigure, piece: RecordedSegment, whose: str) -> None:
    axes: Axes3D = figure.add_subplot(projection="3d")
    found = Ellipsoid.of(piece, POLHODE_POINTS)
    if found is None:
        axes.text2D(0.5, 0.5, "no polhode at rest or along a path", transform=axes.transAxes, ha="center")
        axes.set_axis_off()
        return
    power = 3 * math.floor(np.log10(found.radii.max()) / 3.0)  # slow and fast motions have short numbers as well
    ellipsoid = Ellipsoid(found.radii / 10.0**power, found.polhode / 10.0**power)
    axes.view_init(*VIEW)
    axes.set_proj_type("ortho")
    surface = ellipsoid.surface()
    axes.plot_surface(*surface, color=SURFACE, alpha=0.5, linewidth=0, antialiased=False, shade=False)
    axes.plot_wireframe(*surface, rstride=15, cstride=15, color=FRAME, lw=0.7)  # sections with the principal planes
    facing = (ellipsoid.polhode / ellipsoid.radii**2) @ EYE >= 0.0
    for part, alpha in ((facing, 1.0), (~facing, 0.3)):  # faint behind, as the renderer sorts no lines by depth
        axes.plot(*np.where(part, ellipsoid.polhode.T, np.nan), color=RED, lw=2.6, alpha=alpha, zorder=10)
    axes.plot(*ellipsoid.polhode[:1].T, marker="o", ms=6, color=RED, mec="white", zorder=20)
    _label_axes(axes, ellipsoid.radii, f"$10^{{{power}}}$ rad/s" if power else "rad/s")
    # words of the figure: axes in space do not keep to their frame, as those seen from below have labels above it
    principal = piece.segment.scenario.body().principal_moments
    moments = ", ".join(f"$I_{i}$ = {moment:.4g}" for i, moment in enumerate(principal, start=1))
    figure.suptitle(f"{whose}polhode on the energy ellipsoid, principal frame\n{moments} kg m²", fontsize=10.5)
    figure.supxlabel("dot: first sample; faint: behind", fontsize=9)


def _label_axes(axes: Axes3D, radii: Array, unit: str) -> None:
    names = ("x", "y", "z")
    axes.set(**{f"{name}lim": (-reach, reach) for name, reach in zip(names, 1.05 * radii, strict=True)})
    axes.set_box_aspect(tuple(radii.tolist()), zoom=0.88)
    axes.locator_params(nbins=4, symmetric=True)
    axes.tick_params(pad=_TICK_PAD)
    for i, name in enumerate(names, start=1):
        getattr(axes, f"set_{name}label")(f"$\\omega_{i}$ [{unit}]", labelpad=_LABEL_PAD)


def _title(pieces: Pieces, whose: str) -> str:
    scenario = pieces[0].segment.scenario
    count = len(pieces) - 1
    resets = f", {counted(count, 'reset')} (marks above)" if count else ""
    samples = counted(sum(len(piece.samples) for piece in pieces), "sample")
    others = "".join(f"\n{name}: {phrase}" for name, phrase in facts(scenario).items())
    return f"{whose}{in_words(scenario)}\n{samples} at {scenario.rate:g} Hz{resets}{others}"
