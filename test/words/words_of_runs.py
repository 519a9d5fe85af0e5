"""What simulations, runs, bags of estimates, estimates and the assertion of the plugin refuse."""
# mypy: ignore-errors

from __future__ import annotations

from pathlib import Path

import numpy as np

from lie_rigid_body import Estimate, RigidBody, Run, State, simulate
from lie_rigid_body.foundation.errors import LieRigidBodyError
from lie_rigid_body.testing import assert_attitude

RUN = simulate("tumbling_cubesat", duration=1.0, imu_rate=50.0, motion="closed_form")
Q, T = RUN.truth.attitude_xyzw, RUN.t_ns
BODY, STARTS = RigidBody([1.0, 2.0, 2.5]), State([[0.0, 0.0, 0.0, 1.0]] * 2, [[0.4, -0.3, 0.2]] * 2)
OWN = Run.from_arrays(RUN.imu.t_ns, RUN.imu.gyro, RUN.imu.specific_force)
NO_TIMES = (0.0, np.nan, "60", 10**5000, np.timedelta64(1, "s"))
NO_TOPICS = [{"pos": "/a/pose"}, {"pose": 1}, {1: "/a/pose"}, ["pose"], "pose", "x" * 1000]
NO_NAMES = ("/pose", "/lie_rigid_body/pose", "estimate", "/a b", "", "/" + 255 * "a", 3)
NO_STAMPS = (None, "0", 0.5, [[0], [1, 2]])
NO_SECONDS = (9.0, 1e10, 1e300, -1, np.nan, "10s")
WITH_A_LIMIT = [
    {"estimate": np.tile([0.0, 0.0, 0.0, 1.0], (7, 1))},
    {"estimate": np.full((50, 4), np.nan)},
    *({"after_s": seconds} for seconds in NO_SECONDS),
    {"converged_deg": np.nan},
    {"gyro_bias": np.zeros((3, 3))},
    *({"estimate": estimate} for estimate in (None, "est")),
    {"run": None},
]


def judged(**given):
    """The assertion of the plugin, of an estimate that is right but for what is given."""
    assert_attitude(**{"estimate": RUN.attitude().at(RUN.imu.t_ns), "run": RUN, **given})


def simulated(**given):
    simulate(**{"scenario": "tumbling_cubesat", "duration": 1.0, **given})


def with_estimates(estimates, **more):
    """A bag of these, of which nothing is written where they are refused."""
    try:
        RUN.to_bag("x.mcap", estimates=estimates, **more)
    finally:
        assert not Path("x.mcap").exists()


REFUSED = {
    LieRigidBodyError: [
        lambda: simulated(scenario="perpetual"),
        *(lambda scenario=scenario: simulated(scenario=scenario) for scenario in (5, "a/file", "file.yml", 10**5000)),
        *(lambda duration=duration: simulated(duration=duration) for duration in NO_TIMES),
        lambda: simulated(inertia=memoryview(np.ones((2, 1, 1)))),
        lambda: simulated(seeds=memoryview(np.ones((2, 1, 1)))),
        *(lambda start=start: simulate(BODY, start, duration=1.0) for start in ([0.0, 0.0, 1.0], STARTS)),
        lambda: simulated(imu_rte=3.0),
        lambda: simulated(inertia=[1.0, 1.0, 3.0]),
        lambda: simulated(seeds=[1], sensor_seed=2),
        *(lambda seeds=seeds: simulated(seeds=seeds) for seeds in ([-1], 5, [])),
        lambda: simulated(inertia={1.0, 2.0, 2.5}),
        lambda: simulated(inertia=iter([1.0, 2.0, 2.5])),
        lambda: simulated(memory_limit=1.5),
        lambda: simulated(record_path="x.mcap"),
        *(lambda topics=topics: Run.from_bag("a.mcap", topics=topics) for topics in NO_TOPICS),
        lambda: Estimate(Q.T),
        lambda: Estimate(Q[:, :3]),
        lambda: Estimate(np.zeros((len(T), 3, 3))),
        lambda: Estimate(Q, T / 1e9),
        lambda: Estimate(Q, T[1:]),
        lambda: Estimate(Q, T, np.eye(4)),
        lambda: Estimate(Q, T, np.eye(3), "map"),
        lambda: Estimate(Q, T, None, "world", Q),
        lambda: RUN.score(Q[:17]),
        lambda: RUN.score(Q, T * 0),
        lambda: with_estimates([1]),
        lambda: with_estimates(Q),
        *(lambda name=name: with_estimates({name: (T, Q)}) for name in NO_NAMES),
        lambda: with_estimates({"/mine": Q * np.nan}),
        lambda: with_estimates({"/mine": Q * 0.0}),
        lambda: with_estimates({"/mine": Estimate(Q, gyro_bias=Q[:, :3] * np.nan)}),
        lambda: with_estimates({"/mine": Estimate(Q, covariance=np.eye(3) + np.eye(3, k=1))}),
        lambda: with_estimates({}, scores=[1]),
        *(lambda name=name: getattr(OWN, name) for name in ("scenario", "kicks", "sway", "vibration")),
        lambda: OWN.attitude(),
        lambda: OWN.score(Q),
        lambda: OWN.with_sensors({}).cramer_rao_bound(),
        lambda: OWN.with_sensors({"gyro_noise_densities": 1.0}),
        lambda: OWN.cramer_rao_bound(),
        lambda: OWN.gyro_bias_at(T),
        lambda: OWN.certificate(),
        *(lambda stamps=stamps: RUN.attitude().at(stamps) for stamps in NO_STAMPS),
        *(lambda stamps=stamps: RUN.gyro_bias_at(stamps) for stamps in NO_STAMPS),
        lambda: judged(),
        *(lambda given=given: judged(max_rms_deg=1.0, **given) for given in WITH_A_LIMIT),
        *(lambda limit=limit: judged(max_after=limit) for limit in ("10s", 5)),
        *(lambda limit=limit: judged(max_rms_deg=limit) for limit in (np.nan, "1deg")),
        lambda: RUN.with_sensors({}),
        lambda: Run.from_arrays(T, OWN.imu.gyro, OWN.imu.specific_force, truth="none.tum"),
        lambda: Run.from_arrays(OWN.imu.t_ns, OWN.imu.gyro, OWN.imu.specific_force, truth=(T + 10**12, Q)),
        lambda: Run.from_arrays(OWN.imu.t_ns, OWN.imu.gyro[1:], OWN.imu.specific_force),
        lambda: Run.from_arrays(OWN.imu.t_ns / 1e9, OWN.imu.gyro, OWN.imu.specific_force),
        lambda: Run.from_arrays(OWN.imu.t_ns, OWN.imu.gyro * np.nan, OWN.imu.specific_force),
        lambda: Run.from_arrays([], np.empty((0, 3)), np.empty((0, 3))),
        lambda: Run.from_arrays(OWN.imu.t_ns, OWN.imu.gyro, OWN.imu.specific_force, truth=Q),
        lambda: Run.from_arrays(OWN.imu.t_ns, OWN.imu.gyro, OWN.imu.specific_force, truth=(T, Q * np.nan)),
    ]
}
