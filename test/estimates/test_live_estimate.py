"""An estimate that is followed message by message has the score of its bag."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from estimate_messages import NS, STORE, beside, header, make, messages, vector
from estimate_messages import quaternion as rotation
from mcap.reader import make_reader
from test_rewritten_bags import bag_of

from lie_rigid_body import Estimate, InputError, LieRigidBodyError, Run, Scenario
from lie_rigid_body.estimates import live_estimate
from lie_rigid_body.estimates.buffers import DISORDERED, UNUSABLE
from lie_rigid_body.estimates.live_estimate import LiveEstimate
from lie_rigid_body.estimates.recorded_estimate import recorded_estimate
from lie_rigid_body.evaluation import Limits
from lie_rigid_body.evaluation.attitudes import longest_rising, rising
from lie_rigid_body.lie import quaternion
from lie_rigid_body.messages import decode_string, encode_string
from lie_rigid_body.messages.definitions import IMU, ODOMETRY, POSE_STAMPED, TF_MESSAGE, VECTOR3_STAMPED
from lie_rigid_body.simulation import Segment
from said import numbers
from sampled import sampled
from untyped import evaluate, simulate

SIZE = np.radians(0.5)
HOW = messages(np.eye(3) * SIZE**2)
LIMITS = Limits.parse("1deg", ("1s:1.2deg", "100s:1deg"))
MOTION: dict[str, Any] = {"initial_body_rate": [0.4, 0.6, -0.3], "rate": 25.0, "motion": "closed_form"}
BIASES = "/estimate/gyro_bias"
STEP = 40_000_000
"""Time from one estimate to the next, ns."""
RESET = "The motion began anew at 3 s, 1 reset in all."


@pytest.fixture(scope="module")
def own(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Six seconds with a reset to another start after three."""
    again = {**MOTION, "initial_body_rate": [-0.2, 0.5, 0.4]}
    return bag_of(tmp_path_factory.mktemp("live") / "own.mcap", MOTION, again, each_ns=3 * NS)


@pytest.fixture(scope="module")
def stamps(own: Path) -> np.ndarray:
    """Between those of the truth."""
    return Run.from_bag(own).t_ns[:-1] + 3_000_000


@pytest.fixture(scope="module")
def noisy(own: Path, stamps: np.ndarray) -> np.ndarray:
    noise = np.random.default_rng(2).normal(size=(len(stamps), 3)) * SIZE
    return quaternion.multiply(quaternion.exp(noise), Run.from_bag(own).attitude().at(stamps))


@pytest.fixture
def with_estimate(own: Path, stamps: np.ndarray, noisy: np.ndarray, tmp_path: Path) -> Callable[..., Path]:
    """Writes a bag of the run with an estimate, by default the noisy attitudes at their stamps as poses."""

    def write(t_ns: Any = None, xyzw: Any = None, kind: str = POSE_STAMPED, how: Any = None, without: str = "") -> Path:
        t_ns = stamps if t_ns is None else t_ns
        xyzw = noisy[: len(t_ns)] if xyzw is None else xyzw
        bag = tmp_path / f"{len([*tmp_path.iterdir()])}.mcap"
        heard = t_ns if (np.diff(t_ns) > 0).all() else stamps[0] + STEP * np.arange(len(t_ns))
        return beside(own, bag, (kind, how or HOW[kind], "/estimate", t_ns, xyzw, heard), without=without)

    return write


def of(bag: Path, *, in_file_order: bool = False) -> list[tuple[str, bytes]]:
    return _of(bag, bag.stat().st_mtime_ns, in_file_order=in_file_order)


@cache
def _of(bag: Path, written_ns: int, *, in_file_order: bool) -> list[tuple[str, bytes]]:
    with bag.open("rb") as stream:
        messages = make_reader(stream).iter_messages(log_time_order=not in_file_order)
        return [(channel.topic, message.data) for _, channel, message in messages]


def followed(bag: Path, kind: str, without: tuple[str, ...] = (), **settings: Any) -> Any:
    """The messages of a bag as a live evaluator hears them, some tens at a time."""
    live = LiveEstimate("/estimate", kind, LIMITS, **settings)
    for i, (topic, payload) in enumerate(of(bag)):
        if topic in without:
            continue
        if topic == "/estimate":
            live.hear_estimates([payload])
        elif topic == "/pose":
            live.truth.hear_poses(topic, POSE_STAMPED, [payload])
        elif topic.endswith("/scenario"):
            live.truth.hear_scenarios([payload])
        elif topic == "/estimate/gyro_bias":
            live.gyro_bias.hear(topic, VECTOR3_STAMPED, [payload])
        elif topic == "/imu/bias":
            live.truth.gyro_bias.hear(topic, IMU, [payload])
        if i % 20 == 0:
            live.judge()
    return live


def scored(bag: Path, diagnosed: bool = False, axes: str = "world") -> Any:
    read, how = recorded_estimate(bag, "/estimate"), {"covariance_axes": axes, "diagnosed": diagnosed}
    track = read.track
    return evaluate(track.stamps_ns, track.attitude_xyzw, read.truth, limits=LIMITS, covariance=read.covariance, **how)


def left_out(live: LiveEstimate) -> dict[str, int]:
    return {reason: len(stamps) for reason, stamps in live.estimate.scorable()[1].items() if len(stamps)}


@pytest.mark.parametrize("kind", [POSE_STAMPED, IMU, ODOMETRY, TF_MESSAGE])
def test_the_score_is_that_of_the_bag(kind, with_estimate):
    bag = with_estimate(kind=kind)
    live = followed(bag, kind)
    live.judge()
    live.judge()
    read, score = live.score()
    expected = scored(bag, diagnosed=True)
    assert score.to_dict(series=True) == expected.to_dict(series=True)
    assert (read.motion.source, len(read.motion.segments), read.notes) == ("poses and scenario", 2, (RESET,))
    assert len(score.broken) == 2
    # what is said on the way is the same, of all that could be compared
    assert live.tally.count == live.messages == score.samples
    assert live.tally.rms_deg == pytest.approx([score.total_deg.rms, score.heading_deg.rms, score.inclination_deg.rms])
    assert tuple(live.tally.broken()) == expected.broken


def test_biases_of_the_gyro_have_the_score_of_the_bag(tmp_path: Path) -> None:
    run = simulate("tumbling_cubesat", duration=10.0, sensor_grade="mems", imu_rate=50.0)
    bias = run.imu.gyro_bias + 1e-3 * np.sin(np.arange(500.0) / 100.0)[:, np.newaxis] * [0.6, 0.0, 0.8]
    estimate = Estimate(run.attitude().at(run.imu.t_ns), run.imu.t_ns, gyro_bias=bias)
    run.to_bag(tmp_path / "bag.mcap", estimates={"/estimate": estimate})
    live = followed(tmp_path / "bag.mcap", POSE_STAMPED)
    found = live.score()[1].gyro_bias_rad_s
    expected: Any = recorded_estimate(tmp_path / "bag.mcap", "/estimate").score(LIMITS, "world").gyro_bias_rad_s
    assert found.rms == pytest.approx(expected.rms, rel=1e-12)


def test_biases_that_are_not_finite_count_for_nothing_and_without_true_ones_a_note_says_so(tmp_path: Path) -> None:
    run = simulate("tumbling_cubesat", duration=5.0, sensor_grade="mems", imu_rate=50.0)
    bias = run.imu.gyro_bias + np.array([0.3, 0.0, 0.4])
    estimate = Estimate(run.attitude().at(run.imu.t_ns), run.imu.t_ns, gyro_bias=bias)
    run.to_bag(tmp_path / "bag.mcap", estimates={"/estimate": estimate})
    live = followed(tmp_path / "bag.mcap", POSE_STAMPED)
    payload = next(payload for topic, payload in of(tmp_path / "bag.mcap") if topic == "/estimate/gyro_bias")
    live.gyro_bias.hear("/estimate/gyro_bias", VECTOR3_STAMPED, [payload[:-8] + np.array([np.nan]).tobytes()])
    read, score = live.score()
    found = score.gyro_bias_rad_s
    assert found.rms == pytest.approx(0.5)
    assert [numbers(note) for note in read.notes if "/estimate/gyro_bias" in note] == [[1, 251]]
    read, score = followed(tmp_path / "bag.mcap", POSE_STAMPED, without=("/imu/bias",)).score()
    assert score.gyro_bias is None
    assert [note for note in read.notes if "/estimate/gyro_bias" in note]


def test_biases_of_another_type_are_told_in_a_bag(own, stamps, noisy, tmp_path) -> None:
    topics = [(kind, HOW[kind], name, stamps, noisy) for kind, name in ((POSE_STAMPED, "/estimate"), (IMU, BIASES))]
    read = recorded_estimate(beside(own, tmp_path / "bag.mcap", *topics), "/estimate")
    assert read.gyro_bias is None
    assert [note for note in read.notes if BIASES in note and IMU in note and VECTOR3_STAMPED in note]


@pytest.mark.parametrize(("without", "source"), [("/pose", "scenario"), ("/lie_rigid_body/scenario", "poses")])
def test_scenario_or_poses_alone(without, source, stamps, with_estimate):
    bag = with_estimate(stamps[:70], without=f"/twist {without}")
    read, score = followed(bag, POSE_STAMPED).score()
    assert read.motion.source == source
    assert score.total_deg == scored(bag).total_deg


def test_the_axes_of_the_covariance_are_those_that_are_said(with_estimate):
    how = messages(np.diag([1.0, 2.0, 3.0]) * SIZE**2)[IMU]
    bag = with_estimate(kind=IMU, how=how)
    means = []
    for axes in ("world", "body"):
        found, expected = followed(bag, IMU, covariance_axes=axes).score()[1].consistency, scored(bag, axes=axes)
        assert found.mean == expected.consistency.mean
        means.append(found.mean)
    assert means[0] != pytest.approx(means[1], rel=1e-3)


def test_one_that_begins_late_is_not_reproached(stamps, noisy, with_estimate):
    """Who subscribes to a filter that runs already hears nothing of what it did before."""
    bag = with_estimate(stamps[50:], noisy[50:])
    assert [finding.code for finding in scored(bag).findings] == ["gaps"]
    assert followed(bag, POSE_STAMPED).score()[1].findings == ()
    assert followed(bag, POSE_STAMPED, without=("/pose",)).score()[1].findings == ()


def test_scenarios_without_end_are_counted_and_not_kept(own, monkeypatch):
    monkeypatch.setattr(live_estimate, "MAX_SEGMENTS", 1)
    live = LiveEstimate("/estimate", POSE_STAMPED, LIMITS)
    first, second = (payload for topic, payload in of(own) if topic.endswith("/scenario"))
    live.truth.hear_scenarios([first, second, first, second])
    assert len(live.truth.segments) == 1
    assert live.truth.left_out == 2
    assert [numbers(told)[:1] for told in live.left_out().values()] == [[2]]


def test_of_scenarios_of_one_start_the_last_before_the_samples_counts(own):
    """A node that is reset twice with no sample between, or paused from its start, sends several."""
    live = LiveEstimate("/estimate", POSE_STAMPED, LIMITS)
    first = next(payload for topic, payload in of(own) if topic.endswith("/scenario"))
    segment = Segment.from_json(decode_string(first))
    given = [{**segment.scenario.parameters(), "initial_body_rate": [0.1 * k, 0.0, 1.0]} for k in range(3)]
    others = [replace(segment, scenario=Scenario.from_parameters(parameters)) for parameters in given]
    live.truth.hear_scenarios([first, *(encode_string(other.to_json()) for other in others[:2])])
    assert [*live.truth.segments.values()] == others[1:2]
    for topic, payload in of(own):
        if topic == "/pose":
            live.truth.hear_poses(topic, POSE_STAMPED, [payload])
    live.truth.hear_scenarios([encode_string(others[2].to_json())])
    assert [*live.truth.segments.values()] == others[1:2]
    assert live.truth.left_out == 1


def test_what_is_late_or_goes_back_has_one_score_live_and_from_a_bag(stamps, noisy, with_estimate):
    """One message that is overtaken, a doubled stretch, and a covariance of its own for each."""
    order = np.r_[:60, 61, 60, 62:100, 80:100, 100 : len(stamps)]
    bag = with_estimate(stamps[order], noisy[order], IMU)
    following = followed(bag, IMU, without=("/estimate",))
    for topic, payload in of(bag, in_file_order=True):
        following.hear_estimates([payload] if topic == "/estimate" else [])
    live, recorded = following.score(), recorded_estimate(bag, "/estimate")
    assert live[0].notes == recorded.notes
    assert numbers(recorded.notes[1])[:2] == [20, 169]
    np.testing.assert_array_equal(recorded.track.stamps_ns, live[0].track.stamps_ns)
    assert live[1].to_dict(series=True) == scored(bag, diagnosed=True).to_dict(series=True)


@pytest.mark.parametrize(
    ("kind", "change", "frames"),
    [
        (POSE_STAMPED, {"world": "b/world"}, None),
        (TF_MESSAGE, {"body": "lidar"}, "map to odometer, world to lidar"),
        (ODOMETRY, {"body": "lidar"}, None),
    ],
)
def test_other_frames(kind, change, frames, with_estimate):
    how = messages(np.eye(3), **change)[kind]
    bag = with_estimate(kind=kind, how=how)
    if frames is None:
        _, note = followed(bag, kind).score()[0].notes
        assert repr(*change.values()) in note
        return
    with pytest.raises(InputError, match=frames):
        followed(bag, kind).score()


def test_two_bodies_nothing_and_no_orientation_are_refused(noisy, with_estimate):
    one, other = HOW[POSE_STAMPED], messages(np.eye(3), world="b")[POSE_STAMPED]
    with pytest.raises(LieRigidBodyError, match="world, b"):
        followed(with_estimate(how=lambda t, q: (one if t < NS else other)(t, q)), POSE_STAMPED).score()
    none = messages(np.diag([-1.0, 0.0, 0.0]))[IMU]
    with pytest.raises(InputError, match="orientation"):
        followed(with_estimate(kind=IMU, how=none), IMU).score()
    live = LiveEstimate("/estimate", POSE_STAMPED, LIMITS)
    live.hear_estimates([bytes(STORE.serialize_cdr(one(0, noisy[0]), POSE_STAMPED))])
    with pytest.raises(InputError, match="neither a scenario nor a pose"):
        live.score()
    with pytest.raises(InputError, match="not the JSON"):
        live.truth.hear_scenarios([encode_string("a scene")])


@pytest.mark.parametrize(
    ("shift_ns", "size", "why"),
    [(10**18, 1.0, [0.0, 5.96, 1000000005.923]), (0, np.nan, [149, 149, 0.003]), (0, 0.0, [149, 149, 0.003])],
)
def test_why_nothing_is_compared_though_the_truth_is_known(shift_ns, size, why, stamps, noisy, with_estimate):
    live = followed(with_estimate(stamps + shift_ns, noisy * size), POSE_STAMPED)
    live.judge()
    assert live.tally.count == 0
    assert " /estimate" in live.why_not_compared()
    assert numbers(live.why_not_compared()) == why


def test_what_comes_before_the_truth_waits_for_it(with_estimate):
    bag = with_estimate()
    live = LiveEstimate("/estimate", POSE_STAMPED, LIMITS)
    heard = list(of(bag))
    live.hear_estimates([payload for topic, payload in heard if topic == "/estimate"])
    assert live.judge() is None
    for topic, payload in heard:
        if topic.endswith("/scenario"):
            live.truth.hear_scenarios([payload])
    assert live.score()[1].total_deg.rms == pytest.approx(scored(bag).total_deg.rms, rel=1e-12)


def test_a_filter_that_dies_before_the_end_is_told(own, stamps, noisy):
    """In lock-step the truth ends with it."""
    heard = messages_in_turn(own, stamps, noisy, "")
    whole, half = (live_of(heard, duration_s=duration).score()[1].findings for duration in (5.0, 10.0))
    more = {each.message for each in half} - {each.message for each in whole}
    assert len(more) == 1
    assert [each.code for each in half if each.message in more] == ["gaps"]


def test_a_duration_is_by_stamps_however_late_the_messages_are_read(noisy, with_estimate):
    """As on a loaded machine, which reads the messages of many seconds at once; what comes later cannot spoil it."""
    spoilt = noisy.copy()
    spoilt[[0, 80]] = np.nan
    heard = list(of(with_estimate(xyzw=spoilt)))
    live = LiveEstimate("/estimate", POSE_STAMPED, LIMITS, duration_s=2.0)
    live.truth.hear_scenarios([next(payload for topic, payload in heard if topic.endswith("/scenario"))])
    estimates = [payload for topic, payload in heard if topic == "/estimate"]
    live.hear_estimates(estimates[:40])
    live.judge()
    complete = [live.is_complete]
    live.hear_estimates(estimates[40:])
    live.judge()
    assert [*complete, live.is_complete] == [False, True]
    score = live.score()[1]
    assert (score.t_s[-1], score.samples, left_out(live)) == (2.0, 51, {UNUSABLE: 2})


@pytest.mark.parametrize(
    ("at", "stamp"), sampled([(0, 2**31 * NS - NS), (40, 2**31 * NS - NS), (0, -(10**9) * NS), (40, -(10**9) * NS)], 3)
)
def test_one_wrong_stamp_ends_nothing_and_hides_nothing(at, stamp, own, stamps, noisy):
    wrong, q = stamps.copy(), noisy.copy()
    wrong[at], q[100:] = stamp, [0.0, 0.0, 0.0, 1.0]
    how = HOW[POSE_STAMPED]
    estimates = [bytes(STORE.serialize_cdr(how(*each), POSE_STAMPED)) for each in zip(wrong.tolist(), q, strict=True)]
    live = LiveEstimate("/estimate", POSE_STAMPED, LIMITS, duration_s=5.0)
    live.truth.hear_scenarios([next(payload for topic, payload in of(own) if topic.endswith("/scenario"))])
    poses = [payload for topic, payload in of(own) if topic == "/pose"]
    complete = []
    for i, message in enumerate(estimates):
        live.truth.hear_poses("/pose", POSE_STAMPED, poses[i : i + 1])
        live.hear_estimates([message])
        live.judge()
        complete.append(live.is_complete)
    assert complete.index(True) == 125 + (at == 0)
    _, score = live.score()
    assert score.samples == 126 - (at > 0)
    assert score.total_deg.max > 10.0
    assert len(score.broken) == 3  # with the limit after 100 s
    assert left_out(live) == {DISORDERED: 1}


def test_limits_ask_for_half_of_the_duration(stamps, with_estimate):
    bag = with_estimate(stamps[:60])
    few, enough = (followed(bag, POSE_STAMPED, duration_s=s).score()[1].broken for s in (60.0, 4.0))
    assert numbers(few[-1]) == [2.36, 60]
    assert len(enough) == len(few) - 1


def test_a_clock_ahead_completes_a_duration_too(stamps, with_estimate):
    live = followed(with_estimate(stamps + 10**18), POSE_STAMPED, duration_s=5.0)
    assert live.is_complete
    with pytest.raises(InputError, match="none of its 126 stamps"):
        live.score()


def test_a_score_on_the_way_has_no_gap_up_to_the_end_that_was_asked_for(with_estimate):
    live = followed(with_estimate(), POSE_STAMPED, duration_s=60.0)
    assert [f.code for most in (100, None) for f in live.score(most)[1].findings] == ["gaps"]


@pytest.mark.parametrize("duration_s", [None, 4.0])
def test_poses_ahead_of_a_slow_filter_are_no_gap(duration_s, stamps, with_estimate):
    """The truth is there before the filter has its answer: not what is on its way is missing, but what never comes."""
    codes = {}
    for count in 101, 126, 60:  # the truth is heard until 6 s
        live = followed(with_estimate(stamps[:count]), POSE_STAMPED, duration_s=duration_s)
        codes[count] = [finding.code for finding in live.score()[1].findings]
    assert codes == {101: [] if duration_s else ["gaps"], 126: [], 60: ["gaps"]}


@pytest.mark.parametrize("duration_s", [1e300, np.inf, np.nan, -1.0, 0.0])
def test_what_is_no_duration_is_one_line(duration_s):
    with pytest.raises(InputError, match="is not a time"):
        LiveEstimate("/estimate", POSE_STAMPED, LIMITS, duration_s=duration_s)


def test_a_score_ends_with_as_many_samples_as_it_takes(monkeypatch, with_estimate):
    live = followed(with_estimate(), POSE_STAMPED)
    notes = live.score()[0].notes
    complete = [live.is_complete]
    monkeypatch.setattr(live_estimate, "MAX_SAMPLES", 149)
    assert [*complete, live.is_complete] == [False, True]
    assert [numbers(note) for note in live.score()[0].notes if note not in notes] == [[149]]


def test_a_score_on_the_way_does_not_judge_the_convergence(stamps, noisy, with_estimate):
    wrong = np.radians(150.0) * (stamps < 2.5 * NS)[:, np.newaxis] * [0.0, 0.0, 1.0]
    bag = with_estimate(xyzw=quaternion.multiply(noisy, quaternion.exp(wrong)))
    score = followed(bag, POSE_STAMPED).score(50)[1]
    assert score.samples <= 50
    assert score.stamps_ns[0] > 2.5 * NS
    assert score.findings == ()


def one_pose(stamp: int, attitude: Any, frame: str = "world") -> bytes:
    return bytes(STORE.serialize_cdr(messages(np.eye(3), world=frame)[POSE_STAMPED](stamp, attitude), POSE_STAMPED))


IDENTITY = np.array([0.0, 0.0, 0.0, 1.0])
FUTURE, PAST = 2**31 * NS - NS, -(10**9) * NS
HOSTILE = {
    "other_frame": (one_pose(NS, IDENTITY, "elsewhere"), "of_others"),
    "year_2038": (one_pose(FUTURE, IDENTITY), "disordered"),
    "year_1938": (one_pose(PAST, IDENTITY), "disordered"),
    "zero": (one_pose(5_000_000, np.zeros(4)), "unusable"),
    "not_finite": (one_pose(5_000_000, np.full(4, np.nan)), "unusable"),
}


CASES = [
    (topic, which, place, without)
    for topic in ("/estimate", "/pose")
    for which in HOSTILE
    for place, without in ((0, ""), (1, "/lie_rigid_body/scenario"), (60, ""), (10**6, "/pose"))
    if topic != without
]


@pytest.fixture(scope="module")
def unhurt(own, stamps, noisy):
    """Messages without those of one topic, and their score."""

    @cache
    def heard_without(topic):
        heard = messages_in_turn(own, stamps[:70], noisy[:70], topic)
        return heard, live_of(heard).score()

    return heard_without


@pytest.mark.parametrize(("topic", "which", "place", "without"), sampled(CASES, every=5))
def test_one_hostile_message_costs_itself(topic, which, place, without, stamps, unhurt):
    """The score is the same as if it had not come, and it is counted and told."""
    heard, (expected_read, expected) = unhurt(without)
    at = min(place, len(heard)) if place != 1 else 1 + next(i for i, (name, _) in enumerate(heard) if name == topic)
    if which in ("zero", "not_finite"):  # their stamps go on from the last
        earlier = [i for i, (name, _) in enumerate(heard) if name == topic and i < at]
        stamp = int(stamps[max(len(earlier) - 1, 0)] - (0 if topic == "/estimate" else 3_000_000))
        payload = one_pose(stamp, np.zeros(4) if which == "zero" else np.full(4, np.nan))
    else:
        payload = HOSTILE[which][0]
    spoilt = live_of([*heard[:at], (topic, payload), *heard[at:]])
    read, score = spoilt.score()
    assert score.to_dict(series=True) == expected.to_dict(series=True)
    assert read.motion.source == expected_read.motion.source
    assert {kind.removeprefix("pose ") for kind in spoilt.left_out()} == {HOSTILE[which][1]}
    assert len(read.notes) == len(expected_read.notes) + 1


def transforms_of(*transforms: tuple[int, np.ndarray, str, str]) -> bytes:
    """A message of transforms, each of a stamp, an attitude, a frame and a child frame."""
    each = []
    for stamp, attitude, frame, child in transforms:
        turn = make("geometry_msgs/msg/Transform", vector(), rotation(attitude))
        each.append(make("geometry_msgs/msg/TransformStamped", header(stamp, frame), child, turn))
    return bytes(STORE.serialize_cdr(make(TF_MESSAGE, each), TF_MESSAGE))


def messages_in_turn(bag: Path, stamps: np.ndarray, attitudes: np.ndarray, without: str) -> list[tuple[str, bytes]]:
    """The scenario, and then the poses and the estimates in turn."""
    scenarios = [each for each in of(bag) if each[0].endswith("/scenario") and each[0] != without]
    poses = [each for each in of(bag) if each[0] == "/pose"]
    estimates = [("/estimate", one_pose(*each)) for each in zip(stamps.tolist(), attitudes, strict=True)]
    pairs = [message for pair in zip(poses, estimates, strict=False) for message in pair if message[0] != without]
    return [*scenarios[:1], *pairs]


def live_of(heard: list[tuple[str, bytes]], batch: int = 5, duration_s: float | None = None) -> LiveEstimate:
    live = LiveEstimate("/estimate", POSE_STAMPED, LIMITS, duration_s=duration_s)
    for i in range(0, len(heard), batch):
        part = heard[i : i + batch]
        live.hear_estimates([payload for topic, payload in part if topic == "/estimate"])
        live.truth.hear_scenarios([payload for topic, payload in part if topic.endswith("scenario")])
        live.truth.hear_poses("/pose", POSE_STAMPED, [payload for topic, payload in part if topic == "/pose"])
        live.judge()
    return live


@pytest.mark.slow
def test_transforms_of_a_thousand_other_frames_hide_none(own, stamps, noisy):
    """Whoever else publishes on /tf, and before the estimate."""
    transforms = [(int(stamps[0]), IDENTITY, f"world {i}", f"body {i}") for i in range(1000)]
    live = LiveEstimate("/tf", TF_MESSAGE, LIMITS)
    live.truth.hear_scenarios([payload for topic, payload in of(own) if topic.endswith("/scenario")][:1])
    live.hear_estimates([transforms_of(*transforms)])
    live.judge()
    for stamp, attitude in zip(stamps[:70].tolist(), noisy[:70], strict=True):
        live.hear_estimates([transforms_of((stamp, attitude, "world", "base_link"), *transforms)])
    score = live.score()[1]
    assert score.samples == 70
    assert len(live.estimate.frames) < 30


@pytest.mark.parametrize(
    ("seconds", "left_out"),
    [
        ([0.0, 2.0, 4.0, 6.0, 8.0, 10.0], []),
        ([0.0, 0.1, 0.2, 100.0, 100.1, 100.2, 100.3], []),  # a gap
        ([0.0, 0.0, 0.1, 0.1], []),
        ([0.0, 2.0, 1e9, 4.0, 6.0, 8.0], [2]),
        ([0.0, -1e9, 0.1, 0.2, 0.3], [1]),
        ([1e9, 0.0, 0.1, 0.2, -1e9, 0.3], [0, 4]),
        ([-1e9, 0.0, 0.1, 0.2, 0.3], [0]),
        ([0.0, 0.1, 0.2, 0.3, 1e9], [4]),
        ([0.0, -1e9, 2e9, 0.0, 0.1, 0.2, 0.3], [1, 2]),
        ([*range(0, 60, 4)], []),
        ([0.0, 0.1], []),
        ([5.0], []),
        ([], []),
    ],
)
def test_a_wrong_stamp_costs_itself(seconds: list[float], left_out: list[int]) -> None:
    stamps = np.round(np.array(seconds) * 1e9).astype(np.int64)
    assert np.flatnonzero(~rising(stamps)).tolist() == left_out


def test_as_many_stamps_as_possible_are_in_order() -> None:
    """Beside the longest rising subsequence by comparing all pairs."""
    rng = np.random.default_rng(0)
    for _ in range(50):
        stamps = rng.integers(0, 20, size=15)
        best = np.ones(15, dtype=int)
        for i in range(15):
            best[i] += max((best[j] for j in range(i) if stamps[j] <= stamps[i]), default=0)
        chosen = longest_rising(stamps)
        assert (np.diff(chosen) > 0).all()
        assert (np.diff(stamps[chosen]) >= 0).all()
        assert len(chosen) == best.max()


@pytest.mark.parametrize("rows", [range(3), range(60, 80)])
def test_stamps_beyond_the_truth_cost_themselves_where_later_ones_are_within(rows, stamps, with_estimate):
    """As of a filter that begins by the time of day, before it hears of a simulated one."""
    wrong = stamps.copy()
    wrong[rows] += 10**18
    read = recorded_estimate(with_estimate(wrong), "/estimate")
    assert read.track.stamps_ns.tolist() == np.delete(stamps, rows).tolist()
    assert read.left_out == len(rows)


@pytest.mark.parametrize("without", ["", "/pose /twist"])
def test_the_last_after_a_pause_count(without, stamps, noisy, with_estimate):
    """Within the poses, or without these within the bag."""
    rows = np.r_[:70, 147, 148]
    read = recorded_estimate(with_estimate(stamps[rows], noisy[rows], without=without), "/estimate")
    assert read.track.stamps_ns.tolist() == stamps[rows].tolist()


def test_the_score_of_a_duration_is_the_same_whenever_the_poses_behind_it_come(with_estimate):
    """To the last digit, as a job may compare two of them; until its last pose has come it is not ready."""
    heard = list(of(with_estimate(how=HOW[POSE_STAMPED])))
    estimates = [payload for topic, payload in heard if topic == "/estimate"]
    poses = [payload for topic, payload in heard if topic == "/pose"]
    ready, scores = [], []
    for count in (63, 64, 70, 149):  # the duration ends between the 63rd and the 64th
        live = LiveEstimate("/estimate", POSE_STAMPED, LIMITS, duration_s=2.5)
        live.truth.hear_poses("/pose", POSE_STAMPED, poses[:count])  # which alone tell it: between them it is a spline
        live.hear_estimates(estimates[:101])
        live.judge()
        assert live.is_complete
        ready.append(live.has_its_truth)
        scores.append(live.score()[1].to_dict())
    assert ready == [False, True, True, True]
    assert scores[1] == scores[2] == scores[3] != scores[0]
