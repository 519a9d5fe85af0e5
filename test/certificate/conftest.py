"""The bag with sensors that most tests of readings change copies of."""

from __future__ import annotations

import pytest
from sensor_bags import FORCE, LATER, MOTIONS, NOISY, write


@pytest.fixture(scope="session")
def bag(tmp_path_factory):
    path = tmp_path_factory.mktemp("bags") / "honest.mcap"
    return write(path, ({**MOTIONS["dmv20"], **FORCE, **NOISY}, 0.995))


@pytest.fixture(scope="session")
def pointing(tmp_path_factory):
    """The bag with sensors of attitude and sun."""
    return write(tmp_path_factory.mktemp("bags") / "pointing.mcap", ({**MOTIONS["dmv20"], **LATER}, 0.6))
