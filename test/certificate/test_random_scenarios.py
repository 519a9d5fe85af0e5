"""Honest bags of scenarios drawn at random are certified, whole and late; with a number altered they are not."""

from __future__ import annotations

import random
from typing import Any

import pytest
from sensor_bags import EPOCH, write
from tampering import Change, at, on, tamper, with_numbers

from foreign_bags import Message
from lie_rigid_body.certificate import certify
from lie_rigid_body.foundation.errors import ParameterError
from lie_rigid_body.recording.bag_reader import Bag
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.sensors import SENSORS
from sampled import sampled

SEEDS = 60
BODIES = ([1.0, 2.0, 3.0], [1.0, 1.0, 1e-9], [0.05, 40.0, 40.02], [1.0, 0.1, -0.05, 1.4, 0.2, 1.9], [2.0, 2.0, 2.0])
METHODS = ("dmv20", "dmv8", "rkmk4")
"""Steppers that stay a ground truth with steps of a millisecond at up to 2 rad/s."""
ENDINGS = {
    "probability": (0.01, 0.3, 1.0),
    "latency": (1e-3, 0.1),
    "jitter": (1e-3, 0.1),
    "skew": (-1e-2, 1e-6),
    "offset": (-0.3, 1e-5, 0.2),
    "fault_begin": (0.0, 0.1),
    "inclination_noise": (1e-4, 0.1),
    "heading_noise": (1e-4, 0.1),
    "sight_noise": (1e-4, 0.1),
    "roll_noise": (1e-4, 0.1),
    "sun_sensor_noise": (1e-4, 0.1),
    "misalignment": ([0.1, -0.2, 0.05], [1.0, 2.0, -1.0]),
    "scale_factor": ([1.01, 0.98, 1.0], [1e3, 1.0, -2.0]),
    "lever_arm": ([0.1, 0.0, -0.3], [5.0, 1.0, 2.0]),
}
"""Values of parameters by the ends of their names; of other numbers any size from 1e-8 to 1e4."""


def drawn(chance: random.Random, **fixed: object) -> dict[str, Any]:
    """A possible scenario, of parameters at random but for those that are fixed."""
    while True:
        given = {**proposed(chance), **fixed}
        try:
            Scenario.from_parameters(given)
        except ParameterError:
            continue
        return given


def proposed(chance: random.Random) -> dict[str, Any]:
    """A scenario, perhaps an impossible one, with a third of the parameters of sensors at random."""
    given: dict[str, Any] = {
        "inertia": chance.choice(BODIES),
        "initial_body_rate": [chance.choice((1.0, 1.0, 1e-4)) * chance.uniform(-1.0, 1.0) for _ in range(3)],
        "method": chance.choice(METHODS),
        "motion": chance.choice(("closed_form", "moving_chart")),
        "epoch_ns": EPOCH,
        "imu_rate": chance.choice((100.0, 333.3)),
        **{sensor.switch: chance.choice((0.0, 7.0, 50.0)) for sensor in SENSORS.values() if sensor.name != "imu"},
    }
    for name, parameter in SENSORS.parameters.items():
        if name in given or chance.random() > 0.3 or name.endswith(("_duration", "fault_end", "_frame", "_range")):
            continue
        ending = next((values for end, values in ENDINGS.items() if name.endswith(end)), None)
        if parameter.choices or parameter.kind == "bool":
            given[name] = chance.choice(parameter.choices or (False, True))
        elif parameter.kind == "int":
            given[name] = chance.randrange(2**62)
        elif ending is not None:
            given[name] = chance.choice(ending)
        elif name.endswith("_interval"):
            given[name] = 10.0 ** chance.uniform(-1.5, 0.5)
            given[name.replace("_interval", "_duration")] = given[name] * chance.uniform(0.01, 1.0)
        elif isinstance(parameter.default, float):
            given[name] = 10.0 ** chance.uniform(-8.0, 4.0)
    return given


def late(chance: random.Random) -> Change:
    """What a recorder has that came late, and stopped a little earlier on some topics."""

    def change(messages: list[Message]) -> list[Message]:
        begin, last = EPOCH + chance.randrange(400_000_000), messages[-1].log_time
        ends = {topic: last - chance.choice((0, 3_000_000)) for topic in sorted({m.topic for m in messages})}
        kept = [m for m in messages if m.topic.endswith("/scenario") or begin <= m.log_time <= ends[m.topic]]
        return [m._replace(log_time=m.log_time + 12_345) for m in kept]

    return change


@pytest.mark.parametrize("seed", sampled(range(SEEDS), every=SEEDS // 2))
def test_random_scenarios_are_certified_and_altered_numbers_named(tmp_path, seed):
    chance = random.Random(seed)
    stages = [drawn(chance, rate=100.0) for _ in range(1 + chance.randrange(3))]
    path = write(tmp_path / "a.mcap", *((stage, 0.5) for stage in stages), chunk_size=10_000)
    for change in (lambda ms: ms, late(chance)):
        found = certify(Bag(tamper(path, tmp_path / "b.mcap", change)))
        assert found.passed, (found.messages, stages)
        assert found.to_the_bit is not False
    for topic in found.sensors:
        forge = on(topic, at(0, lambda m: with_numbers(m, 2, lambda x: 1.5 * x + 1e-3)))
        assert not certify(Bag(tamper(path, tmp_path / "c.mcap", forge))).passed, topic
