"""The limits of ``evaluate``: its exit status, by what could be compared, and limits that are none."""

from __future__ import annotations

import re
from typing import Any

import pytest
from estimate_messages import beside
from evaluating import HOW, POSE, scored

from lie_rigid_body.cli.evaluate import main
from said import numbers


def test_limits_are_the_exit_status(bag, capsys):
    given = [bag, "--estimate", "/filter/Imu"]
    assert scored(capsys, *given, "--max-rms", "1deg", "--max-after", "2s:3deg")["passed"] is True
    broken = scored(capsys, *given, "--max-rms", "0.1deg", "--max-after", "2s:1e-3rad", status=1)
    assert broken["passed"] is False
    assert len(broken["broken"]) == 2
    assert main([str(a) for a in given]) == 0
    assert re.search(r"^total +0\.\d+ ", capsys.readouterr().out, re.MULTILINE)


LITTLE: dict[str, Any] = {
    "reversed": (lambda t, q: (t[::-1], q[::-1]), [1, 250]),
    "in microseconds": (lambda t, q: (1000 * t, q), [1, 250]),
    "ends early": (lambda t, q: (t[:6], q[:6]), [0.2, 10]),
}


@pytest.mark.parametrize("case", LITTLE)
def test_a_limit_is_not_kept_by_the_little_that_could_be_compared(case, own, run, stamps, tmp_path, capsys):
    change, little = LITTLE[case]
    q = run.attitude().at(stamps)
    bag = beside(own, tmp_path / "little.mcap", (POSE, HOW[POSE], "/estimate", *change(stamps, q)))
    given = bag, "--estimate", "/estimate"
    assert scored(capsys, *given)["broken"] == []
    content = scored(capsys, *given, "--max-rms", "180deg", status=1)
    assert numbers(content["broken"][0]) == little
    late = beside(own, tmp_path / "late.mcap", (POSE, HOW[POSE], "/estimate", stamps[200:], q[200:]))
    assert scored(capsys, late, "--estimate", "/estimate", "--max-rms", "1deg")["passed"]
