"""Parameters of the sensors of simulated logs come back from an inspection, within their standard errors."""

from __future__ import annotations

import numpy as np
import pytest

import inspection

pytestmark = pytest.mark.slow


def test_parameters_come_back_within_their_standard_errors() -> None:
    """95 % of 100 logs are within two (``benchmarks/inspection.py --round-trip 100``); of eight at least 90 %."""
    errors = [error for seed in range(8) for of_log in inspection.errors_in_sigmas(seed).values() for error in of_log]
    assert len(errors) > 120
    assert np.mean(np.abs(errors) < 2.0) > 0.9
