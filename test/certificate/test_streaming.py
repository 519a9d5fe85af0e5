"""A bag that is read in batches gets the certificate that it gets in memory, whatever the batches."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from sensor_bags import BIAS, IMU, MAG, broken, certificate, laws, recorded, write
from tampering import Change, at, flipped, on, scaled_rate, tamper, with_numbers

from lie_rigid_body.certificate import certify, readings, sensor_topics
from lie_rigid_body.certificate.stamps import DISORDER, DUPLICATE, GAP, StampTally
from lie_rigid_body.recording import bag_reader, samples
from lie_rigid_body.recording.bag_reader import Bag, read_bag
from lie_rigid_body.simulation import SampleClock
from sampled import sampled

COUNT = 700


@pytest.fixture(scope="module", params=[True, False], ids=["stamped", "bare"])
def honest(request, tmp_path_factory):
    path = tmp_path_factory.mktemp("bags") / "honest.mcap"
    rates = {"rate": 100.0, "imu_rate": 0.0, "magnetometer_rate": 0.0}
    first = {"motion": "closed_form", "stamped_twist": request.param, **rates}
    second = {**first, "initial_body_rate": [1.0, 2.0, 0.5]}
    return write(path, (first, COUNT / 100.0 - 0.005), (second, COUNT / 100.0), chunk_size=10_000)


CHANGES = {
    "honest": lambda ms: ms,
    "gap": on("/pose", lambda ms: [*ms[:300], *ms[317:]]),
    "doubled": on("/twist", lambda ms: [*ms[:301], *ms[300:]]),
    "swapped": on("/pose", lambda ms: [*ms[:300], ms[301], ms[300], *ms[302:]]),
    "flipped": on("/pose", at(511, flipped)),
    "scaled": on("/twist", lambda ms: [scaled_rate(1 + 1e-12)(m) if i % 97 == 5 else m for i, m in enumerate(ms)]),
    "cut": on("/twist", lambda ms: ms[:-9]),
    "recorded": lambda ms: [m._replace(log_time=m.log_time + 12_345 + i % 7) for i, m in enumerate(ms)],
}


def every_ninth(change) -> Change:
    return lambda ms: [change(m) if i % 9 == 5 else m for i, m in enumerate(ms)]


READINGS: dict[str, Change] = {
    "honest": lambda ms: ms,
    "gap": on(IMU, lambda ms: [*ms[:100], *ms[117:]]),
    "doubled": on(BIAS, lambda ms: [*ms[:101], *ms[100:]]),
    "swapped": on(MAG, lambda ms: [*ms[:30], ms[31], ms[30], *ms[32:]]),
    "scaled": on(IMU, every_ninth(lambda m: with_numbers(m, 24, lambda x: 1.001 * x))),
    "framed": on(IMU, every_ninth(lambda m: m._replace(data=m.data.replace(b"imu_", b"abc_")))),
    "recorded": recorded(0.21, 0.1),
}


@pytest.fixture
def small_batches(monkeypatch):
    for module, name, size in (
        (bag_reader, "_BATCH", 50),
        (samples, "_HELD_BACK", 4),
        (readings, "REPLAY_BLOCK", 7),
        (sensor_topics, "REPLAY_BLOCK", 7),
    ):
        monkeypatch.setattr(module, name, size)


@pytest.mark.parametrize("change", sampled(CHANGES, every=3))
def test_batches_change_no_number_of_samples(honest, tmp_path, change, request):
    path = tamper(honest, tmp_path / "changed.mcap", CHANGES[change])
    whole = certify(read_bag(path))
    request.getfixturevalue("small_batches")
    assert certify(Bag(path)) == whole


@pytest.mark.parametrize("change", READINGS)
def test_batches_change_no_number_of_readings(bag, tmp_path, change, request):
    path = tamper(bag, tmp_path / "changed.mcap", READINGS[change])
    whole = certify(read_bag(path))
    request.getfixturevalue("small_batches")
    assert certify(Bag(path)) == whole


@pytest.mark.parametrize("change", ["honest", "gap", "recorded"])
def test_a_bag_is_read_once_after_it_is_opened(honest, tmp_path, change):
    path, told = tamper(honest, tmp_path / "changed.mcap", CHANGES[change], 10_000), list[int]()
    certify(Bag(path, told.append))
    assert round(sum(told) / path.stat().st_size) == 2


def test_every_pass_tells_how_far_it_is(honest):
    size = honest.stat().st_size
    told: list[int] = []
    bag = Bag(honest, told.append)
    assert 0.8 * size < sum(told) <= size
    list(bag.batches())
    assert 1.6 * size < sum(told) <= 2 * size


def test_a_topic_far_behind_the_other_is_compared_with_a_replay_of_its_own(bag, small_batches, tmp_path):
    last = lambda ms: [*(m for m in ms if m.topic != BIAS), *(m for m in ms if m.topic == BIAS)]  # noqa: E731
    plain = certificate(bag, tmp_path, recorded(0.0))
    found = certificate(bag, tmp_path, lambda ms: last(recorded(0.0)(ms)))
    assert found.passed, found.messages
    assert laws(found, "gyro bias") == laws(plain, "gyro bias")


def test_readings_on_both_sides_of_a_gap_are_compared(bag, tmp_path):
    fifth = on(IMU, lambda own: own[::5])
    sparse = lambda ms: fifth([m for m in recorded(0.0)(ms) if m.topic not in (MAG, BIAS)])  # noqa: E731
    found = certificate(bag, tmp_path, sparse)
    assert broken(found) == {"IMU stamps"}
    assert found.sensors == (IMU,)
    assert [law.checked for law in laws(found, "gyro")] == [67]
    forged = on(IMU, at(30, lambda m: with_numbers(m, 24, lambda x: np.concatenate([x[:1] + 1e-8, x[1:]]))))
    found = certificate(bag, tmp_path, lambda ms: forged(sparse(ms)))
    assert broken(found) == {"IMU stamps", "gyro"}
    assert [law.sample for law in laws(found, "gyro")] == [150]


@given(st.lists(st.integers(0, 12), min_size=1, max_size=30), st.integers(1, 7))
@example([1, 0, 1], 3)
def test_a_tally_counts_as_the_whole_list_does(numbers, batch):
    clock = SampleClock(5, 10.0)
    tally = StampTally(clock)
    stamps = np.array([clock.stamp_ns(k) for k in numbers])
    for i in range(0, len(stamps), batch):
        tally.add(stamps[i : i + batch])
    faults = {fault.kind: fault for fault in tally.faults("pose", 0, 12)}
    missing = sorted(set(range(13)) - set(numbers))
    doubled = sorted(k for k in set(numbers) if numbers.count(k) > 1)
    back = [a for a, b in itertools.pairwise(numbers) if b < a]
    for kind, found in ((GAP, missing), (DUPLICATE, doubled), (DISORDER, back)):
        count = len(numbers) - len({*numbers}) if kind == DUPLICATE else len(found)
        assert (kind in faults) == bool(found)
        if found:
            assert (faults[kind].count, faults[kind].sample) == (count, min(found))
