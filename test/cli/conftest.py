"""The run that ``evaluate`` is tested with, noisy estimates of it, and the bags of both.

What `rosbags` writes is loaded where it is used: without that library all other tests of this folder remain.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lie_rigid_body import Run, simulate
from lie_rigid_body.evaluation import Score, scoring
from lie_rigid_body.lie import quaternion


@pytest.fixture
def undiagnosed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Scores without the search for causes, which takes longest: for tests of other things."""
    monkeypatch.setattr(scoring, "diagnose", lambda *given: scoring.Diagnosis())


@pytest.fixture(scope="session")
def run() -> Run:
    motion: dict[str, Any] = {
        "initial_body_rate": [0.4, 0.6, -0.3],
        "motion": "closed_form",
        "rate": 20.0,
        "imu_rate": 25.0,
    }
    return simulate("tumbling_cubesat", duration=10.0, **motion)


@pytest.fixture(scope="session")
def stamps(run: Run) -> np.ndarray:
    return run.imu.t_ns


@pytest.fixture(scope="session")
def noisy(run: Run, stamps: np.ndarray) -> np.ndarray:
    from evaluating import SIZE

    noise = np.random.default_rng(1).normal(size=(len(stamps), 3)) * SIZE
    return quaternion.multiply(quaternion.exp(noise), run.attitude().at(stamps))


@pytest.fixture(scope="session")
def score(run: Run, noisy: np.ndarray) -> Score:
    return run.score(noisy)


@pytest.fixture(scope="session")
def own(run: Run, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("evaluate") / "run.mcap"
    run.to_bag(path)
    return path


@pytest.fixture(scope="session")
def bag(own: Path, stamps: np.ndarray, noisy: np.ndarray) -> Path:
    """The run with the same estimate in each type of message."""
    from estimate_messages import beside
    from evaluating import HOW

    topics = [(kind, how, f"/filter/{kind.rpartition('/')[2]}", stamps, noisy) for kind, how in HOW.items()]
    return beside(own, own.with_name("bag.mcap"), *topics)
