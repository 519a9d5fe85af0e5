"""Public objects can be pickled, copied and sent to other processes, and each shows itself in one short line."""

from __future__ import annotations

import copy
import enum
import importlib
import inspect
import multiprocessing
import pickle
import pkgutil
import re
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lie_rigid_body
from foreign_bags import decode
from lie_rigid_body import (
    ClosedForm,
    MovingChart,
    ParameterError,
    RigidBody,
    Run,
    Scenario,
    State,
    evaluation,
    groups,
    league,
    mechanics,
    messages,
    simulate,
)
from lie_rigid_body import sensors as table
from lie_rigid_body.campaign import Campaign
from lie_rigid_body.certificate import certify
from lie_rigid_body.conformance import CASES, Conformance, EngineMistake, EngineRow
from lie_rigid_body.diagnosis import FilterDiagnosis, Mistake, Note, Probe
from lie_rigid_body.evaluation import cramer_rao_bound
from lie_rigid_body.foundation import errors as errors_room
from lie_rigid_body.foundation.wording import MAX_LINE
from lie_rigid_body.inspection import Estimated, Inspection, LogMistake, LogNote, Mark, Undecided
from lie_rigid_body.messages.batch import BatchEncoder
from lie_rigid_body.motion import METHODS
from lie_rigid_body.motion.description import describe
from lie_rigid_body.motion.moser_veselov.loop import LOOP
from lie_rigid_body.recording import bag_reader
from lie_rigid_body.recording.bag_writer import BagWriter
from lie_rigid_body.simulation import Simulation

TIMES = np.arange(0, 2_000_000_000, 10_000_000)
BODY, START = RigidBody([1.0, 2.0, 3.0]), State([0, 0, 0, 1], [0.01, 1.0, 0.01])
SENSORS: dict[str, Any] = {
    "imu_rate": 100.0,
    "magnetometer_rate": 50.0,
    "gyro_noise_density": 1e-3,
    "gyro_rate": "integrated",
    "imu_latency": 1e-3,
    "attitude_sensor_rate": 5.0,
    "sun_sensor_rate": 5.0,
}
MOTIONS: dict[str, Callable[[], Any]] = {
    "closed form": lambda: ClosedForm(BODY, START),
    "dmv20": lambda: MovingChart(BODY, START),
    "rkmk4": lambda: MovingChart(BODY, START, method="rkmk4"),
    "dmv6": lambda: MovingChart(BODY, START, method="dmv6", max_step=0.01),
}
WAYS = {"pickled": lambda one: pickle.loads(pickle.dumps(one)), "copied": copy.copy, "deep-copied": copy.deepcopy}


@pytest.fixture(scope="module")
def objects(tmp_path_factory: pytest.TempPathFactory) -> list[Any]:
    """Objects of every public class, large where they can be."""
    motions = [make() for make in MOTIONS.values()]
    mistake = Mistake("gyro_axes", "a message" * 50, "y x z", 100.0, 0.0)
    probe, note = Probe("follows", passed=True, message="a message", value=0.0), Note("causal", "a message", 1.0)
    found = [
        mistake,
        probe,
        note,
        FilterDiagnosis((mistake,), (probe,), (note,), 100, 100.0, 0.1),
        BODY,
        START,
        ClosedForm(BODY, START).at(TIMES),
        *motions,
        *METHODS.values(),
        describe(BODY, START),
    ]
    found += [mechanics.box(1.0, [0.1, 0.2, 0.3]), LOOP, *errors()]
    found += [*of_a_run(tmp_path_factory.mktemp("bags") / "run.mcap"), *of_a_score(), *of_the_league(), *of_a_group()]
    found += [*of_an_inspection(), *of_an_engine()]
    if find_spec("flint"):
        from lie_rigid_body.proof import FlintMissingError, enclose

        found += [enclose([1.0, 2.0, 3.0], [0, 0, 0, 1], [0.01, 1.0, 0.01], 10**9), FlintMissingError("no flint")]
    return found


def of_an_inspection() -> list[Any]:
    run = simulate(duration=1.0, imu_rate=100.0)
    parts: tuple[Any, ...] = (
        LogMistake("gyro_units", "gyro", "a message" * 50, "× 0.01745", 10.0, 0.01),
        Undecided("gyro_axes", "a message" * 50),
        LogNote("noise", "a message" * 50, 1.0),
        Estimated(1.0, 0.1),
        Mark("imu", "rest", 0, 1),
    )
    mistake, undecided, note, estimated, mark = parts
    return [
        *parts,
        Inspection((mistake,), (undecided,), (note,), {"gyro_noise_density": estimated}, run, (mark,), {}, {}),
    ]


def of_an_engine() -> list[Any]:
    row = EngineRow("a case", 2.0, 1e-3, "not judged", 1e-9, 1e-16)
    found = EngineMistake("damped", "a message" * 50, ("a case",))
    return [CASES[0], row, found, Conformance((row,), (found,), (found,))]


def errors() -> list[Exception]:
    kinds = [kind for kind in vars(errors_room).values() if inspect.isclass(kind) and issubclass(kind, Exception)]
    arguments = {
        ParameterError: ("rate", "0 is too low"),
        errors_room.ChoiceError: ("two bodies: {choice}", "pose", "/a/pose"),
    }
    return [kind(*arguments.get(kind, ("x" * 10_000,))) for kind in kinds]


def of_a_run(path: Path) -> list[Any]:
    simulation: Any = Simulation(Scenario.from_parameters(SENSORS))
    scenario, first = simulation.segment.scenario, simulation.segment
    models = scenario.sensors.on.values()
    sensors = [queue._compute.__self__._instrument for queue in simulation._running[-1].sensors.values()]
    taken = simulation.take_until(2 * 10**9, 200)
    with BagWriter(path, stamped_twist=True) as bag:
        bag.begin_segment(first)
        bag.write(BatchEncoder(scenario).encode(taken))
    recording = bag_reader.read_bag(path)
    certificate = certify(recording)
    encoders: list[Any] = [messages.PoseTwistEncoder(scenario), messages.TransformEncoder("a", "b")]
    poses = decode(encoders[0].poses(taken.samples), messages.POSE_NUMBERS, stamped=True)
    laws = [certificate, certificate.segments[0], certificate.segments[0].laws[0]]
    readings = [taken, taken.samples, *taken.sensors.values(), *taken.faults, *sensors]
    campaign = Campaign(3, 7, 1.0, vary={"sensor_seed": {"distribution": "run"}})
    return [
        *readings,
        *(campaign, scenario, scenario.sensors, table.SensorModel(1.0, 7), *models, scenario.sensors.imu.delivery),
        *(first, simulation.clock, simulation),
        *laws,
        *encoders,
        *of_the_table(scenario),
        poses,
        recording,
        *of_arrays(Run.from_bag(path)),
        *of_arrays(simulate(duration=2.0, **SENSORS)),
    ]


def of_the_table(scenario: Scenario) -> list[Any]:
    sensors = list(table.SENSORS.values())
    pairs = [(topic, scenario.sensors.on[sensor.name]) for sensor in sensors for topic in sensor.topics]
    signal = table.Signal(np.zeros((3, 3)), scenario.sensors.imu.gyro.converter)
    encoders = [messages.ReadingEncoder(topic, model, scenario) for topic, model in pairs]
    return [*sensors, *(topic for topic, _ in pairs), pairs[0][0].fields[0], signal, *encoders]


def of_arrays(run: Run) -> list[Any]:
    estimate = lie_rigid_body.Estimate(run.truth.attitude_xyzw, run.t_ns)
    return [run, run.imu, run.magnetometer, run.attitude_sensor, run.sun, run.attitude(), estimate]


def of_a_score() -> list[Any]:
    truth = ClosedForm(BODY, START).at(TIMES).attitude_xyzw
    turned = State(truth[:, [3, 0, 1, 2]], np.zeros((len(truth), 3))).attitude_xyzw
    sampled, score_limits = evaluation.SampledTruth(TIMES, truth), evaluation.Limits(1.0)
    score = evaluation.evaluate(TIMES, turned, sampled, limits=score_limits, covariance=1e-4 * np.eye(3))
    exact = evaluation.ExactTruth(exact_attitudes, 0, int(TIMES[-1]))
    bias = cramer_rao_bound.BiasNoise(0.1, 0.01)
    up = cramer_rao_bound.VectorReadings(TIMES, np.array([0.0, 0.0, 9.8]), 0.1, bias)
    bound = cramer_rao_bound.cramer_rao_bound(TIMES, truth, cramer_rao_bound.NoisySensors(0.1, bias, [up]))
    found = [score, score.consistency, score.total_deg, *score.findings, score.error, score_limits, sampled, exact]
    return [*found, bias, up, cramer_rao_bound.AttitudeReadings(TIMES, np.eye(3)), bound]


def of_the_league() -> list[Any]:
    table = league.reference()
    return [table, table.rows[0], league.CASES[-1]]


def exact_attitudes(t_ns: np.ndarray) -> np.ndarray:
    return ClosedForm(BODY, START).at(t_ns).attitude_xyzw


def of_a_group() -> list[Any]:
    group = groups.SO(4)
    lagrangian = groups.Lagrangian(group, groups.mass_matrix(np.diag([0.1, 0.2, 0.3, 0.4]), group.generators))
    chart = groups.GroupMovingChart(
        lagrangian, groups.GroupState(group.identity, np.array([0.3, -0.2, 0.5, 0.1, 0.4, -0.6]))
    )
    hamiltonian = groups.legendre_transform(lagrangian)
    equations = hamiltonian.equations(np.ones(6))
    points = np.random.default_rng(0).normal(size=(100, 3))
    steady = groups.steady_rotation(lagrangian, np.eye(6)[0])
    own = groups.MatrixLieGroup.from_generators(group.generators[:1], name="one " * 100)
    return [
        group,
        own,
        lagrangian,
        chart,
        chart.at(TIMES[:20]),
        hamiltonian,
        equations,
        groups.chasles(points, points),
        steady,
        groups.chart_reach(group, np.eye(6)[0]),
    ]


def public_classes() -> Iterator[type]:
    """Every class among the public names of the package and of its rooms that has instances."""
    rooms = [lie_rigid_body, errors_room]
    for module in pkgutil.iter_modules(lie_rigid_body.__path__, "lie_rigid_body."):
        if module.name.endswith((".proof", ".ros")) and not find_spec("flint" if "proof" in module.name else "rclpy"):
            continue
        rooms.append(importlib.import_module(module.name))
    for room in rooms:
        for name in getattr(room, "__all__", ()):
            kind = getattr(room, name)
            if inspect.isclass(kind) and not (inspect.isabstract(kind) or getattr(kind, "_is_protocol", False)):
                yield kind


def test_there_is_an_object_of_every_public_class(objects):
    missing = {kind.__name__ for kind in public_classes() if not issubclass(kind, enum.Enum)}
    assert missing - {type(one).__name__ for one in objects} == set()


@pytest.mark.parametrize("way", WAYS)
def test_every_public_object_is_equal_to_its_copies(objects, way):
    for one in objects:
        assert same(one, WAYS[way](one)), one


def same(one: Any, other: Any) -> bool:
    """Whether two objects are of one class and made of the same parts, by what pickle takes from them."""
    if type(one) is not type(other):
        return False
    if isinstance(one, np.ndarray):
        return np.array_equal(one, other, equal_nan=one.dtype.kind in "fc")
    if isinstance(one, list | tuple):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, dict):
        return list(one) == list(other) and all(map(same, one.values(), other.values()))
    if one is other or isinstance(one, int | float | str | bytes):
        return one is other or one == other
    if type(one).__name__ == "Enclosure":  # python-flint rounds a radius up, in the last of its 30 bits
        balls = zip(one.attitude_xyzw + one.body_rate, other.attitude_xyzw + other.body_rate, strict=True)
        return all(y.contains(x) for x, y in balls) and other.width <= one.width * (1 + 1e-8)
    if isinstance(one, Exception) and str(one) != str(other):
        return False
    parts, others = one.__reduce_ex__(4), other.__reduce_ex__(4)
    return not isinstance(parts, str) and same(tuple(parts[1:3]), tuple(others[1:3]))


@pytest.mark.parametrize("way", WAYS)
def test_what_was_read_only_stays_so(way):
    for one in (BODY, START, ClosedForm(BODY, START).at(TIMES), groups.SO(3), of_a_group()[2]):
        other = WAYS[way](one)
        names = [name for name in dir(one) if isinstance(getattr(one, name), np.ndarray)]
        fixed = [name for name in names if not getattr(one, name).flags.writeable]
        assert fixed
        assert all(not getattr(other, name).flags.writeable for name in fixed), one


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("name", MOTIONS)
def test_a_motion_under_way_and_its_copy_go_on_to_the_same_bits_by_themselves(name, way):
    one = MOTIONS[name]()
    one.at(TIMES[:70])
    other = WAYS[way](one)
    expected = one.at(TIMES[70:])
    for k in (70, 130):  # the copy does not feel how far the first has gone
        assert same(other.at(TIMES[k : k + 60]), part(expected, k - 70))


def part(states: State, k: int) -> State:
    some = slice(k, k + 60)
    return State.trusted(states.attitude_xyzw[..., some, :], states.body_rate[..., some, :])


@pytest.mark.parametrize("way", WAYS)
def test_a_simulation_and_its_copy_go_on_to_the_same_bits_by_themselves(way):
    one = Simulation(Scenario.from_parameters(SENSORS))
    one.take_until(10**9, 30)
    other = WAYS[way](one)
    expected = one.take_until(10**9, 40)
    assert same(other.take_until(10**9, 40), expected)


def energies(motion: Any) -> np.ndarray:
    return BODY.kinetic_energy(motion.at(TIMES))


def refused(moments: list[float]) -> RigidBody:
    return RigidBody(moments)


@pytest.mark.slow
@pytest.mark.long
def test_motions_results_and_refusals_pass_through_a_pool_of_spawned_processes():
    with multiprocessing.get_context("spawn").Pool(1) as pool:
        motion = MovingChart(BODY, START)
        states = pool.apply_async(motion.at, (TIMES,)).get(timeout=60)
        assert same(states, MovingChart(BODY, START).at(TIMES))
        assert same(
            pool.apply_async(energies, (ClosedForm(BODY, START),)).get(timeout=60), energies(ClosedForm(BODY, START))
        )
        with pytest.raises(ParameterError) as refusal:
            pool.apply_async(refused, ([1.0, 1.0, 3.0],)).get(timeout=60)
        assert refusal.value.name == "inertia"


def test_a_repr_is_one_short_line_whatever_the_size(objects):
    for one in objects:
        if not isinstance(one, Exception):
            assert len(repr(one)) <= MAX_LINE, repr(one)
            assert len(repr(one).splitlines()) == 1
            assert not re.search(r"\d\.\.\.|\.\.\.\d", repr(one)), repr(one)  # no number is cut


def test_the_repr_of_states_gives_shapes_and_ends():
    states = State(
        np.tile([0.0, 0.0, 0.0, 1.0], (1_000_000, 1)), np.linspace([0.0, 1.0, 2.0], [3.0, 4.0, 5.0], 1_000_000)
    )
    assert repr(states) == (
        "State(attitude_xyzw=<(1000000, 4), [0, 0, 0, 1] to [0, 0, 0, 1]>, "
        "body_rate=<(1000000, 3), [0, 1, 2] to [3, 4, 5]>)"
    )
    assert repr(START) == "State(attitude_xyzw=[0.0, 0.0, 0.0, 1.0], body_rate=[0.01, 1.0, 0.01])"
    assert repr(BODY) == "RigidBody([[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]])"


def test_the_repr_of_a_scenario_is_the_call_that_makes_it():
    for given in ({}, {"rate": 200.0}, {"inertia": [1.0, 2.0, 2.5], "motion": "closed_form", "epoch_ns": 7}):
        scenario = Scenario.from_parameters(given)
        assert same(eval(repr(scenario), {"Scenario": Scenario}), scenario)
    assert repr(Scenario.from_parameters({"rate": 200})) == "Scenario(rate=200.0)"


def test_the_repr_of_a_certificate_is_its_verdict(tmp_path):
    path = tmp_path / "run.mcap"
    simulate(duration=0.5, motion="closed_form").to_bag(path)
    found = certify(bag_reader.read_bag(path))
    accuracy = f"{found.attitude_accuracy:.2g}"
    assert repr(found) == f"<Certificate: certified, attitude within {accuracy} rad; 50 samples in 1 segment>"
    assert repr(found.segments[0]) == (
        f"<SegmentCertificate: certified, attitude within {accuracy} rad; 50 samples from 0 ns>"
    )
    wrong = certify(bag_reader.read_bag(path), inertia=[1.0, 2.0, 2.5])
    assert repr(wrong).startswith("<Certificate: broken: attitude, body rate")
    assert repr(wrong).endswith("; 50 samples in 1 segment>")
