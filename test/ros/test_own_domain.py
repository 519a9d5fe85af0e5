"""Domains for filters: each is of one player at a time, whatever other users have left in the shared folder."""

from __future__ import annotations

import os
import tempfile
from importlib.util import find_spec
from pathlib import Path

import pytest

from lie_rigid_body.errors import LieRigidBodyError

if find_spec("rclpy"):
    from lie_rigid_body.ros import play

pytestmark = pytest.mark.ros


def test_what_others_have_left_holds_no_domain_and_leads_nowhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr(play, "DOMAINS", range(1, 5))
    os.mkfifo(tmp_path / "ros-domain-1.lock")  # whoever opens it to read would wait for a writer
    (tmp_path / "ros-domain-2.lock").symlink_to(tmp_path / "made elsewhere")
    (tmp_path / "ros-domain-3.lock").touch(mode=0o444)
    with play.own_domain() as one, play.own_domain() as two, play.own_domain() as three:
        assert {one, two, three} == {1, 3, 4}
        with pytest.raises(LieRigidBodyError), play.own_domain():
            pass
    with play.own_domain() as again:
        assert again in (1, 3, 4)
    assert not (tmp_path / "made elsewhere").exists()
