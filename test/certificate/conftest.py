"""The bag with sensors that most tests of readings change copies of."""

from __future__ import annotations

import pytest
from sensor_bags import FORCE, MOTIONS, NOISY, write

from lie_rigid_body.simulation.samples import Measurement


@pytest.fixture(scope="session")
def bag(tmp_path_factory):
    path = tmp_path_factory.mktemp("bags") / "honest.mcap"
    return write(path, ({**MOTIONS["dmv20"], **FORCE, **NOISY}, 0.995))


@pytest.fixture
def replayed(monkeypatch):
    """How many readings were replayed at once, each time."""
    counts: list[int] = []
    replay = Measurement.replay

    def counted(measurement, count):
        counts.append(count)
        return replay(measurement, count)

    monkeypatch.setattr(Measurement, "replay", counted)
    return counts
