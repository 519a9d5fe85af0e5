"""``plot``: one PNG, with what it promises to show, and nothing overwritten."""

from __future__ import annotations

import numpy as np
import pytest
from test_check import write_bag

from lie_rigid_body.cli.plot import main
from lie_rigid_body.recording.bag_reader import read_bag
from lie_rigid_body.recording.certificate.segments import cut
from lie_rigid_body.recording.figure import draw


@pytest.fixture
def bag(tmp_path):
    return write_bag(tmp_path / "bag.mcap")


def refused(capsys, arguments: list[str]) -> str:
    assert main(arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    return err


def test_a_picture_is_written_and_kept(bag, tmp_path, capsys):
    out = tmp_path / "out.png"
    assert main([str(bag), "-o", str(out)]) == 0
    picture = out.read_bytes()
    assert picture.startswith(b"\x89PNG")
    assert len(picture) > 50_000
    capsys.readouterr()
    assert "--force" in refused(capsys, [str(bag), "-o", str(out)])
    assert out.read_bytes() == picture
    assert main([str(bag), "-o", str(out), "--force"]) == 0


def test_bad_places_and_bags(bag, tmp_path, capsys):
    assert "ends in .png" in refused(capsys, [str(bag), "-o", str(tmp_path / "out.pdf")])
    assert "does not exist" in refused(capsys, [str(bag), "-o", str(tmp_path / "nowhere" / "out.png")])
    assert "absent.mcap" in refused(capsys, [str(tmp_path / "absent.mcap"), "-o", str(tmp_path / "out.png")])
    assert list(tmp_path.glob("*.png")) == []


def test_it_shows_rate_drifts_and_polhode_with_units(bag):
    figure = draw(cut(read_bag(bag)))
    rate, energy, momentum, polhode = figure.axes
    assert "rad/s" in rate.get_ylabel()
    assert "energy drift" in energy.get_ylabel()
    assert "momentum drift" in momentum.get_ylabel()
    assert "[s]" in momentum.get_xlabel()
    assert all("rad/s" in label() for label in (polhode.get_xlabel, polhode.get_ylabel, polhode.get_zlabel))
    recorded = read_bag(bag).twists.body_rates
    for i, line in enumerate(rate.get_lines()):
        np.testing.assert_array_equal(line.get_ydata(), recorded[:, i])
    assert np.abs(energy.get_lines()[0].get_ydata()).max() < 1e-13


@pytest.mark.parametrize("inertia", [[3.0, 1.0, 2.0], [1.0, 0.1, -0.05, 1.4, 0.2, 1.9]])
def test_the_polhode_lies_on_the_ellipsoid(inertia, tmp_path):
    """Every point of the drawn path obeys ½ Σ Iᵢωᵢ² = H in the axes' own, principal, coordinates."""
    bag = write_bag(tmp_path / "bag.mcap", inertia=inertia, initial_body_rate=[0.4, -1.2, 0.7])
    pieces = cut(read_bag(bag))
    body = pieces[0].segment.scenario.body()
    polhode = draw(pieces).axes[3]
    paths = [line for line in polhode.get_lines() if line.get_linewidth() > 2]
    assert paths
    for line in paths:
        points = np.array(line.get_data_3d())
        energy = 0.5 * np.nansum(body.principal_moments[:, np.newaxis] * points**2, axis=0)
        drawn = ~np.isnan(points).any(axis=0)
        np.testing.assert_allclose(energy[drawn], body.kinetic_energy(pieces[0].segment.scenario.start()), rtol=1e-12)


@pytest.mark.parametrize(
    "parameters", [{"initial_body_rate": [0, 0, 0]}, {"inertia": [2, 2, 2]}, {"initial_body_rate": [0, 0, 3]}]
)
def test_degenerate_motions_are_drawn(parameters, tmp_path):
    draw(cut(read_bag(write_bag(tmp_path / "bag.mcap", 5, **parameters)))).canvas.draw()


def test_a_single_sample_is_drawn(tmp_path):
    draw(cut(read_bag(write_bag(tmp_path / "bag.mcap", 1)))).canvas.draw()
