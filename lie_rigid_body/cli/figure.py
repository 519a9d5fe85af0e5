"""The picture of a recording: body rate, drift of energy and momentum, and the polhode on the energy ellipsoid."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lie_rigid_body.arrays import Array
from lie_rigid_body.cli.plotly_layout import COLOURS, GREY
from lie_rigid_body.errors import BagError
from lie_rigid_body.lie import so3
from lie_rigid_body.recording.samples import RecordedSegment
from lie_rigid_body.wording import counted

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure, SubFigure
    from mpl_toolkits.mplot3d.axes3d import Axes3D

MOST_RESETS_AS_LINES: Final = 12
"""Largest number of resets drawn as lines through the curves; more are short marks at the upper edge."""

INTERVALS: Final = 60
"""Number of intervals of time, each of which an envelope shows by its smallest and its largest value."""

FEW_SAMPLES: Final = 3
"""Largest number of samples of a segment that a line alone would hardly show."""
MANY_SAMPLES: Final = 20_000
"""Number of samples of a segment above which the curves of a fast motion fill whole areas."""

_VIEWS: Final = tuple(
    (elevation, quarter + azimuth)
    for elevation in (24.0, 45.0, -24.0)
    for quarter in (0.0, 90.0, 180.0, 270.0)
    for azimuth in (35.0, 20.0, 55.0, 70.0)
)
"""Elevations and azimuths, degrees, that a polhode may be seen from: off the axes, so that all three are seen."""
_FROM_BELOW: Final = 0.8
"""Merit of a view from below, which is less usual, as a share of that from above."""
_SEEN_POINTS: Final = 400
"""Number of points by which a view is judged."""
_SHORT_NUMBER: Final = 3
"""Characters of a number that keeps clear of its axis at the usual distance."""
_TICK_PAD, _LABEL_PAD, _HALF_DIGIT = 3.5, 8.0, 3.0
"""Points: from an axis to numbers and label, and half of a digit's width."""
_NO_RATE: Final = 1e150
"""rad/s: squares of more may overflow; a rate that was damaged does not choose the view."""


def draw(pieces: Sequence[RecordedSegment]) -> Figure:
    """The picture of a recording.

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
    from matplotlib.figure import Figure

    pieces = [piece for piece in pieces if len(piece.samples)]
    if not pieces:
        raise BagError("no sample has both a pose and a twist of the same stamp: record both topics together")
    figure = Figure(figsize=(13.0, 7.6), dpi=120, layout="constrained")
    halves: Any = figure.subfigures(1, 2, width_ratios=(1.25, 1.0), wspace=0.05)
    over_time, of_space = halves
    rate, energy, momentum = over_time.subplots(3, 1, sharex=True, height_ratios=(1.35, 1.0, 1.0))
    _draw_rate(rate, pieces)
    _draw_energy(energy, pieces)
    _draw_momentum(momentum, pieces)
    _draw_polhode(of_space, pieces[0], "first segment: " if len(pieces) > 1 else "")
    _finish(figure, (rate, energy, momentum), pieces)
    return figure


def _times(piece: RecordedSegment, pieces: Sequence[RecordedSegment]) -> Array:
    return np.asarray((piece.stamps_ns - pieces[0].stamps_ns[0]) * 1e-9)


def _style(piece: RecordedSegment, width: float) -> dict[str, Any]:
    """The line style of a segment's curves: few points as dots, many so that one curve does not hide the others."""
    count = piece.count
    if count <= FEW_SAMPLES:
        return {"marker": "o", "ms": 4.0, "lw": width}
    return {"lw": 0.5 * width, "alpha": 0.6} if count > MANY_SAMPLES else {"lw": width}


def _draw_rate(axes: Axes, pieces: Sequence[RecordedSegment]) -> None:
    for piece in pieces:
        for i, (name, colour) in enumerate(zip("xyz", COLOURS, strict=True)):
            label = rf"$\omega_{name}$" if piece is pieces[0] else None
            axes.plot(
                _times(piece, pieces), piece.states.body_rate[:, i], color=colour, label=label, **_style(piece, 1.4)
            )
    axes.set_ylabel("body rate [rad/s]")
    _legend(axes)


def _draw_energy(axes: Axes, pieces: Sequence[RecordedSegment]) -> None:
    def drift(piece: RecordedSegment) -> Array:
        scenario = piece.segment.scenario
        start = float(scenario.body().kinetic_energy(scenario.start()))
        return (scenario.body().kinetic_energy(piece.states) - start) / (start or 1.0)

    _draw_envelope(axes, pieces, np.concatenate([drift(piece) for piece in pieces]), GREY)
    axes.set_ylabel("energy drift\n$(H - H_0)/H_0$")


def _draw_momentum(axes: Axes, pieces: Sequence[RecordedSegment]) -> None:
    def drift(piece: RecordedSegment) -> Array:
        scenario = piece.segment.scenario
        start = scenario.body().angular_momentum(scenario.start())
        return (scenario.body().angular_momentum(piece.states) - start) / (float(so3.norm(start)) or 1.0)

    drifts = np.concatenate([drift(piece) for piece in pieces])
    for i, (name, colour) in enumerate(zip("xyz", COLOURS, strict=True)):
        _draw_envelope(axes, pieces, drifts[:, i], colour, rf"$L_{name}$")
    axes.set_ylabel("world momentum drift\n" + r"$(L - L_0)/|L_0|$")
    axes.set_xlabel(f"time since the first sample [s]; bands: smallest to largest of each 1/{INTERVALS}")
    _legend(axes)


def _draw_envelope(
    axes: Axes, pieces: Sequence[RecordedSegment], values: Array, colour: str, label: str | None = None
) -> None:
    """The smallest and the largest value in each interval of time, as a band: others are seen through it."""
    t, lowest, highest = envelope(np.concatenate([_times(piece, pieces) for piece in pieces]), values)
    dots: dict[str, Any] = {"marker": "o", "ms": 4.0} if len(t) <= FEW_SAMPLES else {}
    axes.fill_between(t, lowest, highest, color=colour, alpha=0.2, lw=0.0)
    axes.plot(t, lowest, color=colour, lw=0.9, **dots)
    axes.plot(t, highest, color=colour, lw=0.9, label=label)


def envelope(t: Array, values: Array) -> tuple[Array, Array, Array]:
    """The smallest and the largest value in each of `INTERVALS` equal parts of the samples, or of each sample.

    Parameters
    ----------
    t, values : ndarray, shape (N,)

    Returns
    -------
    t, lowest, highest : ndarray, shape (M,)
        The times in the middle of the parts.
    """
    if len(t) <= INTERVALS:
        return t, values, values
    first = np.linspace(0, len(t), INTERVALS, endpoint=False).astype(np.int64)
    last = np.append(first[1:], len(t)) - 1
    return 0.5 * (t[first] + t[last]), np.minimum.reduceat(values, first), np.maximum.reduceat(values, first)


def _legend(axes: Axes) -> None:
    """A legend above the axes, where it hides nothing."""
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=3, frameon=False, borderaxespad=0.1)


def _draw_polhode(figure: SubFigure, piece: RecordedSegment, whose: str) -> None:
    """The path of ω in the principal frame, on the ellipsoid ½ Σ Iᵢωᵢ² = H."""
    axes: Axes3D = figure.add_subplot(projection="3d")
    body = piece.segment.scenario.body()
    energy = float(body.kinetic_energy(piece.segment.scenario.start()))
    if energy == 0.0:
        axes.text2D(0.5, 0.5, "at rest: no polhode", transform=axes.transAxes, ha="center")
        axes.set_axis_off()
        return
    radii = np.sqrt(2.0 * energy / body.principal_moments)
    path = np.stack([piece.states.body_rate[: piece.close] @ axis for axis in body.principal_axes.T], axis=-1)
    axes.view_init(*best_view(path, radii))
    axes.set_proj_type("ortho")
    _draw_ellipsoid(axes, radii)
    _draw_on_surface(axes, path, radii, colour="#CC2222", width=2.6)
    axes.plot(*path[:1].T, marker="o", ms=6, color="#CC2222", mec="white", zorder=20)
    _label_axes(axes, radii)
    # words of the figure: axes in space do not keep to their frame, as those seen from below have labels above it
    moments = ", ".join(f"$I_{i}$ = {moment:.4g}" for i, moment in enumerate(body.principal_moments, start=1))
    title = f"{whose}polhode on the energy ellipsoid, principal frame\n{moments} kg m²"
    figure.suptitle(title, fontsize=10.5)
    figure.supxlabel("dot: first sample; faint: behind", fontsize=9)


def best_view(path: Array, radii: Array) -> tuple[float, float]:
    """Elevation and azimuth, degrees, from which most of a curve on an ellipsoid is in front, and widest.

    Parameters
    ----------
    path : ndarray, shape (N, 3)
    radii : ndarray, shape (3,)
        Semi-axes of the ellipsoid.

    Returns
    -------
    tuple of float
    """
    points = path[:: len(path) // _SEEN_POINTS + 1]
    points = points[(np.abs(points) < _NO_RATE).all(axis=1)]
    if not len(points):
        return _VIEWS[0]

    def merit(view: tuple[float, float]) -> tuple[float, float]:
        eye, right, up = _screen(*view)
        in_front = float(np.mean((points / radii**2) @ eye >= 0.0))
        seen = points @ np.stack([right, up], axis=-1)
        # the lesser of the two widths of the curve on the screen: 0 if it is seen as a chord
        width = float(np.linalg.svd(seen - seen.mean(axis=0), compute_uv=False)[-1]) / len(seen) ** 0.5
        usual = 1.0 if view[0] > 0.0 else _FROM_BELOW
        return round(usual * in_front * width / float(radii.max()), 9), usual * in_front

    return max(_VIEWS, key=merit)


def _screen(elevation: float, azimuth: float) -> tuple[Array, Array, Array]:
    """Unit vectors towards the eye, to the right and up, of a view in degrees."""
    e, a = np.radians(elevation), np.radians(azimuth)
    eye = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    right = np.array([-np.sin(a), np.cos(a), 0.0])
    return eye, right, np.cross(eye, right)


def _draw_ellipsoid(axes: Axes3D, radii: Array) -> None:
    u, v = np.meshgrid(np.linspace(0, 2 * np.pi, 61), np.linspace(0, np.pi, 31))
    sphere = np.array([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)])
    x, y, z = radii[:, np.newaxis, np.newaxis] * sphere
    axes.plot_surface(x, y, z, color="#C9D6E8", alpha=0.5, linewidth=0, antialiased=False, shade=False)
    for plane in range(3):
        angle = np.linspace(0, 2 * np.pi, 181)
        ring = np.insert(np.stack([np.cos(angle), np.sin(angle)], axis=-1), plane, 0.0, axis=-1)
        _draw_on_surface(axes, radii * ring, radii, colour="#8A97A8", width=0.7)


def _draw_on_surface(axes: Axes3D, path: Array, radii: Array, *, colour: str, width: float) -> None:
    """A curve on the ellipsoid, faint where it runs behind, as the renderer does not sort lines by depth."""
    eye, _, _ = _screen(axes.elev, axes.azim)
    facing = (path / radii**2) @ eye >= 0.0
    for visible, alpha in ((False, 0.25), (True, 1.0)):
        part = np.where((facing == visible)[:, np.newaxis], path, np.nan)
        axes.plot(*part.T, color=colour, lw=width, alpha=alpha, zorder=10 if visible else 1, solid_capstyle="round")


def _label_axes(axes: Axes3D, radii: Array) -> None:
    """Limits, ticks and labels; of slow and fast motions in units of a power of 1000, so that numbers are short."""
    from matplotlib.ticker import FuncFormatter, MaxNLocator

    reach = 1.05 * radii
    axes.set(xlim=(-reach[0], reach[0]), ylim=(-reach[1], reach[1]), zlim=(-reach[2], reach[2]))
    axes.set_box_aspect(tuple(float(r) for r in radii / radii.max()), zoom=0.88)
    power = 3 * int(np.floor(np.log10(radii.max()) / 3.0))
    unit = f"$10^{{{power}}}$ rad/s" if power else "rad/s"
    for i, axis in enumerate((axes.xaxis, axes.yaxis, axes.zaxis), start=1):
        axis.set_major_locator(MaxNLocator(nbins=4, symmetric=True))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value / 10.0**power:g}".replace("-", "−")))
        longest = max(map(len, axis.get_major_formatter().format_ticks(axis.get_majorticklocs())))
        beyond = _HALF_DIGIT * max(0, longest - _SHORT_NUMBER)  # numbers have their middle at a distance from the axis
        axis.set_tick_params(pad=_TICK_PAD + beyond)
        axis.set_label_text(f"$\\omega_{i}$ [{unit}]")
        axis.labelpad = _LABEL_PAD + 2.0 * beyond


def _finish(figure: Figure, axes: Sequence[Axes], pieces: Sequence[RecordedSegment]) -> None:
    for a in axes:
        a.grid(alpha=0.3, lw=0.6)
        a.margins(x=0.0)
        a.label_outer()
        _mark_resets(a, [(piece.segment.start_ns - pieces[0].stamps_ns[0]) * 1e-9 for piece in pieces[1:]])
    figure.suptitle(_title(pieces), fontsize=11)


def _mark_resets(axes: Axes, times: Sequence[float]) -> None:
    lines = len(times) <= MOST_RESETS_AS_LINES
    lowest, look = (0.0, {"lw": 0.8, "ls": "--"}) if lines else (0.95, {"lw": 0.6})
    axes.vlines(times, lowest, 1.0, transform=axes.get_xaxis_transform(), color="black", **look)


def _title(pieces: Sequence[RecordedSegment]) -> str:
    scenario = pieces[0].segment.scenario
    inertia = ", ".join(f"{v:g}" for v in scenario.inertia)
    rate = ", ".join(f"{v:g}" for v in scenario.initial_body_rate)
    motion = scenario.motion
    if motion == "moving_chart":
        motion = f"moving chart {scenario.method}, step at most {scenario.max_step:g} s"
    total = sum(piece.count for piece in pieces)
    samples = counted(total, "sample")
    count = len(pieces) - 1
    mark = "dashed" if count <= MOST_RESETS_AS_LINES else "marks above"
    resets = f", {count} reset{'s' * (count > 1)} ({mark})" if count else ""
    whose = "first segment: " if len(pieces) > 1 else ""
    return (
        f"torque-free body, {whose}inertia [{inertia}] kg m², initial body rate [{rate}] rad/s\n"
        f"{motion.replace('_', ' ')}; {samples} at {scenario.rate:g} Hz{resets}"
    )
