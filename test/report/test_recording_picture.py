"""The picture of a recording: what it shows, where words and curves are, and the motion that is drawn."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from test_check import write_bag
from test_rewritten_bags import bag_of

from lie_rigid_body.certificate import certify
from lie_rigid_body.foundation.errors import BagError
from lie_rigid_body.mechanics import State
from lie_rigid_body.recording.bag_reader import read_bag
from lie_rigid_body.report.recorded_motion import (
    MAX_PIECES,
    POLHODE_POINTS,
    Ellipsoid,
    ResidualsOverTime,
    path,
    recorded_segments,
)
from lie_rigid_body.report.recording_picture import draw
from lie_rigid_body.scenario.parameter_file import read_parameter_file, scenario_files
from said import numbers


@pytest.fixture
def bag(tmp_path):
    return write_bag(tmp_path / "bag.mcap")


def title(figure) -> str:
    """What is written above the panels; Matplotlib 3.7 has no getter for it."""
    return "\n".join(text.get_text() for text in figure.texts)


def test_it_shows_rate_drifts_and_polhode_with_units(bag):
    figure = draw(recorded_segments(read_bag(bag)))
    rate, energy, momentum = panels = figure.axes[:3]
    polhode: Any = figure.axes[3]
    shown = ("rad/s", "energy", "momentum")
    assert all(word in axes.get_ylabel() for word, axes in zip(shown, panels, strict=True))
    assert "[s]" in momentum.get_xlabel()
    assert all("rad/s" in label() for label in (polhode.get_xlabel, polhode.get_ylabel, polhode.get_zlabel))
    recorded = read_bag(bag).twists.values[:, 3:]
    for i, line in enumerate(rate.get_lines()):
        np.testing.assert_array_equal(line.get_ydata(), recorded[:, i])
    assert np.abs(energy.get_lines()[0].get_ydata()).max() < 1e-13


@pytest.mark.parametrize("inertia", [[3.0, 1.0, 2.0], [1.0, 0.1, -0.05, 1.4, 0.2, 1.9]])
def test_the_polhode_lies_on_the_ellipsoid(inertia, tmp_path):
    """Every point of the drawn path obeys ½ Σ Iᵢωᵢ² = H in the axes' own, principal, coordinates."""
    bag = write_bag(tmp_path / "bag.mcap", inertia=inertia, initial_body_rate=[0.4, -1.2, 0.7])
    pieces = recorded_segments(read_bag(bag))
    body, start = pieces[0].segment.scenario.body(), pieces[0].segment.scenario.start()
    ellipsoid: Any = Ellipsoid.of(pieces[0], 50)
    surface = ellipsoid.surface()
    energies = 0.5 * surface.reshape(3, -1).T ** 2 @ body.principal_moments
    np.testing.assert_allclose(energies, body.kinetic_energy(start), rtol=1e-9)
    for section in (surface[0, :, 15], surface[1, :, 30], surface[2, 15]):  # as the wire frame has them
        assert np.abs(section).max() < 1e-15 * ellipsoid.radii.max()
    polhode: Any = draw(pieces).axes[3]
    paths = [line for line in polhode.get_lines() if line.get_linewidth() > 2]
    assert sum(int(np.sum(~np.isnan(line.get_data_3d()[0]))) for line in paths) == len(path(pieces[0], POLHODE_POINTS))
    assert paths
    for line in paths:
        points = np.array(line.get_data_3d())
        energy = 0.5 * np.nansum(body.principal_moments[:, np.newaxis] * points**2, axis=0)
        drawn = ~np.isnan(points).any(axis=0)
        np.testing.assert_allclose(energy[drawn], body.kinetic_energy(start), rtol=1e-12)


KICKED: dict[str, Any] = {
    "initial_body_rate": [0.0, 0.0, 0.0],
    "kicks": [1.0, 0.4, -1.2, 0.7, 2.0, 0.0, 0.0, 0.0, 2.5, 3.0, 0.0, -1.0],
    "translation": "carried",
    "initial_position": [5.0, 0.0, 0.0],
    "sway_acceleration": [1.0, 2.0, 3.0],
}


def test_of_a_kicked_body_each_arc_keeps_its_own_energy_and_the_first_that_moves_is_on_its_ellipsoid(tmp_path):
    recording = read_bag(write_bag(tmp_path / "bag.mcap", **KICKED))
    [piece] = recorded_segments(recording)
    figure = draw([piece])
    _, position, energy, momentum, _ = figure.axes
    for drift in (energy, momentum):
        assert max(np.abs(line.get_ydata()).max() for line in drift.get_lines()) < 1e-13
    for i, line in enumerate(position.get_lines()):
        np.testing.assert_array_equal(line.get_ydata(), recording.poses.values[:, i])
    assert "[m]" in position.get_ylabel()
    found: Any = Ellipsoid.of(piece, 1000)
    np.testing.assert_array_equal(found.polhode, piece.states.body_rate[100:200])
    assert 0.5 * np.array([1.0, 2.0, 3.0]) @ found.radii**2 / 3.0 == pytest.approx(0.5 * (0.16 + 2.88 + 1.47))
    grown = replace(piece, states=State.trusted(piece.states.attitude_xyzw, 1.01 * piece.states.body_rate))
    drifts: Any = draw([grown]).axes[2].get_lines()[0].get_ydata()
    assert np.abs(drifts[250:]).max() == pytest.approx(0.0201, rel=1e-3)  # of the fastest arc


def test_along_a_path_there_are_no_empty_panels(tmp_path):
    knots = [number for k in range(5) for number in (0.5 * k, k, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)]
    figure = draw(recorded_segments(read_bag(write_bag(tmp_path / "bag.mcap", motion="path", path_knots=knots))))
    rate, position, _ = figure.axes
    assert len(rate.get_lines()) == len(position.get_lines()) == 3
    assert position.get_xlabel()


def test_a_single_sample_is_seen(tmp_path):
    figure = draw(recorded_segments(read_bag(write_bag(tmp_path / "bag.mcap", 1))))
    figure.canvas.draw()
    assert numbers(title(figure))[-2:] == [1, 100]
    for axes in figure.axes[:3]:
        assert [line.get_marker() for line in axes.get_lines()].count("o") == (1 if axes is figure.axes[1] else 3)


def test_many_samples_do_not_hide_each_other(tmp_path):
    bags = [write_bag(tmp_path / f"{n}.mcap", n, motion="closed_form") for n in (99, 30_000)]
    few, many = (draw(recorded_segments(read_bag(bag))) for bag in bags)
    assert few.axes[0].get_lines()[0].get_alpha() is None
    assert (many.axes[0].get_lines()[0].get_alpha() or 1.0) < 1.0


@pytest.mark.parametrize("resets", [2, 40])
def test_many_resets_are_marks_and_no_wall_of_lines(tmp_path, resets):
    bag = bag_of(tmp_path / "bag.mcap", *[{"motion": "closed_form"}] * (resets + 1), each_ns=50_000_000)
    figure = draw(recorded_segments(read_bag(bag)))
    assert numbers(title(figure))[-1] == resets
    [marks] = [c for c in figure.axes[0].collections if isinstance(c, LineCollection)]
    heights = [np.ptp(path[:, 1]) for path in marks.get_segments()]
    assert len(heights) == resets
    assert max(heights) <= 0.1


def segments(tmp_path, *counts: int) -> list:
    """Pieces of recordings of the given numbers of samples; 0 for one whose poses and twists do not pair."""
    pieces = []
    for number, count in enumerate(counts):
        bag = write_bag(tmp_path / f"{number}.mcap", max(1, count), inertia=[1, 2, 2.5 + 0.5 * number])
        [piece] = recorded_segments(read_bag(bag))
        kept = {name: getattr(piece, name)[:count] for name in ("samples", "stamps_ns", "states")}
        pieces.append(replace(piece, **kept))
    return pieces


def test_segments_without_samples_are_left_out(tmp_path):
    without, with_samples = segments(tmp_path, 0, 50)
    figure = draw([without, with_samples])
    figure.canvas.draw()
    assert "[1, 2, 3]" in title(figure)
    assert numbers(title(figure))[-2:] == [50, 100]
    with pytest.raises(BagError):
        draw([without])


def test_of_several_segments_the_first_is_named(tmp_path):
    pieces = segments(tmp_path, 50, 50)
    label, alone = (draw(some).subfigs[1].texts[0].get_text() for some in (pieces, pieces[:1]))
    assert label != alone
    assert label.endswith(alone)
    figure = draw(pieces)
    assert label.removesuffix(alone) in title(figure)
    assert "[1, 2, 2.5]" in title(figure)
    assert numbers(title(figure))[-3:] == [100, 100, 1]


@pytest.mark.slow
def test_the_label_of_the_polhode_keeps_clear_of_the_other_panels(bag):
    figure = draw(recorded_segments(read_bag(bag)))
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    *others, polhode = cast(Any, figure.axes)
    left = max(axes.get_tightbbox().x1 for axes in others)
    assert polhode.zaxis.get_tightbbox(canvas.get_renderer()).x0 > left


@pytest.mark.slow
def test_words_and_numbers_keep_clear_of_the_axes(tmp_path):
    """Slow rates are in units that make short numbers."""
    slow = read_parameter_file(scenario_files()["tumbling_cubesat"])
    figure = draw(recorded_segments(read_bag(write_bag(tmp_path / "bag.mcap", 1200, **slow))))
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    polhode, renderer = cast(Any, figure.axes[3]), canvas.get_renderer()
    axes = (polhode.xaxis, polhode.yaxis, polhode.zaxis)
    for text in figure.subfigs[1].texts:
        box = text.get_window_extent(renderer)
        assert not any(box.overlaps(axis.get_tightbbox(renderer)) for axis in axes)
    for axis in axes:
        assert "$10^{-3}$ rad/s" in axis.label.get_text()
        assert max(len(text) for text in axis.get_major_formatter().format_ticks(axis.get_majorticklocs())) <= 4
        boxes = [tick.label1.get_window_extent(renderer) for tick in axis.get_major_ticks()]
        assert not any(a.overlaps(b) for a, b in pairwise(boxes))


@pytest.mark.parametrize("block", [1, 7, 997, 10_000])
def test_no_peak_of_a_law_is_lost(block):
    """Whatever the blocks are, and in whichever order readings stand in a bag."""
    rng = np.random.default_rng(0)
    stamps = 5_000_000_000 + rng.permutation(3000) * 7_000_000
    residuals, limits = rng.random(3000), 0.5 + rng.random(3000)
    residuals[1234] = np.nan
    watch = ResidualsOverTime()
    for i in range(0, 3000, block):
        watch("law", "", residuals[i : i + block], limits[i : i + block], stamps[i : i + block])
    t, largest, limit, broken = watch.series("law", 5_000_000_000)
    assert len(t) <= MAX_PIECES * -(-3000 // block)
    assert (np.diff(t) >= 0.0).all()
    assert 0.0 <= t[0] <= t[-1] <= 21.0
    finite = np.isfinite(largest)
    assert (largest[~finite].tolist(), largest[finite].max()) == ([np.inf], np.nanmax(residuals))
    assert limit.max() == limits.max()
    beyond = ~(residuals <= limits)
    assert broken.any()
    assert broken.sum() == beyond.sum() or block > 30


@pytest.fixture(scope="module")
def two_segments(tmp_path_factory: pytest.TempPathFactory) -> Path:
    given = {"motion": "closed_form", "initial_body_rate": [0.3, 1.0, 0.2]}
    path = tmp_path_factory.mktemp("bags") / "bag.mcap"
    return bag_of(path, given, given, each_ns=11 * 10**9, chunk_size=10_000)


def test_all_samples_are_drawn_of_the_segments_that_a_certificate_tells(two_segments):
    recording = read_bag(two_segments)
    found = recorded_segments(recording)
    told = recorded_segments(recording, certify(recording))
    assert [len(each.samples) for each in found] == [1100, 1100]
    for one, other in zip(found, told, strict=True):
        assert one.segment == other.segment
        np.testing.assert_array_equal(one.stamps_ns, other.stamps_ns)
    np.testing.assert_array_equal(np.concatenate([each.stamps_ns for each in found]), recording.poses.stamps_ns)


def test_to_watch_changes_nothing_and_sees_the_worst(two_segments):
    recording, watch = read_bag(two_segments), ResidualsOverTime()
    certificate = certify(recording, watch=watch)
    assert certificate == certify(recording)
    assert set(watch.pieces) == {law.name for law in certificate.segments[0].laws} - {"stamps"}
    for law in certificate.laws:
        if law.name in watch.pieces:
            t, largest, _, broken = watch.series(law.name, 0)
            assert largest.max() == law.worst == max(s.law(law.name).worst for s in certificate.segments)
            assert not broken.any()
            assert 0.0 <= t[0] <= t[-1] <= 22.0
