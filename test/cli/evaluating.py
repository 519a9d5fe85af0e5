"""What the tests of ``evaluate`` share: types of messages, the verb's JSON, and its refusals."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from estimate_messages import messages

from lie_rigid_body.cli.evaluate import main

SIZE = np.radians(0.5)
P = np.eye(3) * SIZE**2
HOW = messages(P)
POSE = "geometry_msgs/msg/PoseStamped"
IMU = "sensor_msgs/msg/Imu"
TF = "tf2_msgs/msg/TFMessage"
ODOMETRY = "nav_msgs/msg/Odometry"


def scored(capsys: pytest.CaptureFixture[str], *arguments: object, status: int = 0) -> dict[str, Any]:
    """The JSON of the verb, which ends with the given status and complains of nothing."""
    capsys.readouterr()
    assert main([*map(str, arguments), "--json"]) == status
    out, err = capsys.readouterr()
    assert err == ""
    content: dict[str, Any] = json.loads(out)
    return content


def refused(capsys: pytest.CaptureFixture[str], *arguments: object) -> str:
    """The one line of complaint of the verb, which says nothing else and ends with status 2."""
    capsys.readouterr()
    assert main([str(a) for a in arguments]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    return err
