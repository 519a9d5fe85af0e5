"""Runs behind the standard simulator services, one for each test."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from standard_simulator import Simulator, running


@pytest.fixture
def playing() -> Iterator[Simulator]:
    with running(paused=False) as simulator:
        yield simulator


@pytest.fixture
def paused() -> Iterator[Simulator]:
    with running(paused=True) as simulator:
        yield simulator
