"""``evaluate --out``: a bag of truth, estimates and errors, read by libraries that know nothing of this package."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from estimate_messages import beside
from evaluating import HOW, POSE, P, refused, scored
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader

from lie_rigid_body import Run, certify
from lie_rigid_body.cli.evaluate import main
from lie_rigid_body.lie import quaternion

pytestmark = pytest.mark.usefixtures("undiagnosed")

POSES = "/filter/PoseWithCovarianceStamped"


def by_mcap(path: Path) -> dict[str, list[Any]]:
    """Stamps and messages of each topic, decoded by the definitions that the bag itself has."""
    ros2 = pytest.importorskip("mcap_ros2.decoder")
    found: dict[str, list[Any]] = {}
    with path.open("rb") as stream:
        for _, channel, _, message in make_reader(
            stream, decoder_factories=[ros2.DecoderFactory()]
        ).iter_decoded_messages():
            found.setdefault(channel.topic, []).append(message)
    return found


def by_rosbags(path: Path) -> dict[str, list[Any]]:
    found: dict[str, list[Any]] = {}
    with AnyReader([path]) as reader:
        for connection, _, raw in reader.messages():
            found.setdefault(connection.topic, []).append(reader.deserialize(raw, connection.msgtype))
    return found


def stamps_of(messages: list[Any]) -> list[int]:
    return [m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for m in messages]


def vectors(messages: list[Any]) -> np.ndarray:
    return np.array([[m.vector.x, m.vector.y, m.vector.z] for m in messages])


@pytest.fixture(scope="module")
def out(bag: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("out") / "scored.mcap"
    given = [str(bag), "--estimate", POSES, "--estimate", "/filter/TFMessage", "--estimate", "/filter/Imu"]
    assert main([*given, "--out", str(path)]) == 0
    return path


@pytest.mark.parametrize("read", [by_mcap, by_rosbags])
def test_errors_and_nees_are_those_of_the_score(read, out, run, stamps, noisy):
    found = read(out)
    score = run.score(noisy, covariance=P)
    for topic in (POSES, "/filter/TFMessage/estimate", "/filter/Imu"):
        errors = found[f"{topic}/error_deg"]
        assert stamps_of(errors) == stamps.tolist()
        np.testing.assert_allclose(np.radians(vectors(errors)), np.stack(score.error, axis=-1), rtol=1e-12, atol=1e-15)
    nees = vectors(found[f"{POSES}/nees"])
    np.testing.assert_allclose(nees[:, 0], score.consistency.nees, rtol=1e-9)
    assert nees[0, 1:].tolist() == list(score.consistency.bounds)
    assert "/filter/TFMessage/estimate/nees" not in found
    given = np.array([[q.x, q.y, q.z, q.w] for q in (m.pose.pose.orientation for m in found[POSES])])
    np.testing.assert_array_equal(given, noisy)
    assert len(found["/pose"]) == len(found["/twist"]) == len(run.t_ns)


def test_the_truth_is_still_certified_and_the_estimates_have_the_same_score(out, bag, own, capsys):
    assert certify(out).passed
    assert np.array_equal(Run.from_bag(out).truth.attitude_xyzw, Run.from_bag(own).truth.attitude_xyzw)
    again, first = (scored(capsys, path, "--estimate", POSES) for path in (out, bag))
    assert again["nees"]["mean"] == pytest.approx(first["nees"]["mean"], rel=1e-12)
    assert again["total_deg"] == first["total_deg"]


def test_covariances_on_the_bodys_axes_come_out_on_the_worlds(own, run, stamps, noisy, tmp_path, capsys):
    uneven = np.diag([1.0, 4.0, 9.0]) * P
    how = with_covariance(uneven)
    bag, out = beside(own, tmp_path / "body.mcap", (*how, "/f", stamps, noisy)), tmp_path / "out.mcap"
    first = scored(capsys, bag, "--estimate", "/f", "--covariance-axes", "body", "--out", out)
    again = scored(capsys, out, "--estimate", "/f")
    assert again["nees"]["mean"] == pytest.approx(first["nees"]["mean"], rel=1e-9)


def with_covariance(covariance: np.ndarray) -> tuple[str, Any]:
    from estimate_messages import messages

    kind = "geometry_msgs/msg/PoseWithCovarianceStamped"
    return kind, messages(covariance)[kind]


def test_an_estimate_that_has_the_name_of_the_truth_gets_another(own, stamps, noisy, tmp_path, capsys):
    alone = beside(own, tmp_path / "alone.mcap", (POSE, HOW[POSE], "/pose", stamps, noisy), without="/pose /twist")
    out = tmp_path / "out.mcap"
    first = scored(capsys, alone, "--estimate", "/pose", "--truth", own, "--out", out)
    assert scored(capsys, out, "--estimate", "/pose/estimate")["total_deg"] == first["total_deg"]
    assert certify(out).passed


def test_of_two_bodies_the_truth_of_the_estimate_is_written(own, stamps, noisy, tmp_path, capsys):
    run = Run.from_bag(own)
    other = quaternion.multiply([0.0, 0.0, 1.0, 0.0], run.truth.attitude_xyzw)
    bag = beside(
        own,
        tmp_path / "two.mcap",
        (POSE, HOW[POSE], "/b/pose", run.t_ns, other),
        (*with_covariance(P), "/f", stamps, noisy),
    )
    out = tmp_path / "out.mcap"
    scored(capsys, bag, "--estimate", "/f", "--topic", "pose:=/pose", "--out", out)
    assert np.array_equal(Run.from_bag(out).truth.attitude_xyzw, run.truth.attitude_xyzw)


def test_what_cannot_be_written_is_one_line(own, bag, out, tmp_path, capsys):
    given = [bag, "--estimate", POSES, "--out"]
    poses = beside(own, tmp_path / "poses.mcap", without="/lie_rigid_body/scenario /twist")
    new = tmp_path / "new.mcap"
    assert "/twist" in refused(capsys, *given, new, "--truth", poses)
    assert not new.exists()
    assert main([*map(str, given), str(out), "--force"]) == 0
    assert certify(out).passed
