"""Engines are judged: integrators of our own, right and with each mistake put in, in double and single precision."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from collections.abc import Collection, Iterable
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from judged.own import MISTAKES, ONE_SIDED, RIGHT, engine, exact, expected
from lie_rigid_body.conformance import CASES, Conformance, judge
from lie_rigid_body.conformance.results import noise
from lie_rigid_body.foundation.errors import InputError, ParameterError
from lie_rigid_body.lie import quaternion
from sampled import sampled

EXAMPLE = Path(__file__).parents[2] / "examples" / "engine" / "free_body.cpp"
SCRIPT = EXAMPLE.with_name("judge_program.py")
STILL = """
import json, sys
case = json.loads(sys.stdin.readline())
for n in range(case["steps"]):
    print((n + 1) * case["step"], *case["attitude_xyzw"], *case["body_rate"], sep=",")
"""
ORDERS = (
    dict.fromkeys(RIGHT, 2.0) | dict.fromkeys([name for name in RIGHT if name.endswith("Euler")], 1.0) | {"RK4": 4.0}
)
PUT_IN = [mistake for mistake in MISTAKES if mistake]
OF_EACH_CODE = {code: mistake for mistake, code in reversed(MISTAKES.items())}.values()
QUICK = {"semi-implicit Euler", "RK4"}
"""Engines of every run: each takes seconds to be compiled."""
pytestmark = pytest.mark.long


def some(cases: Iterable[str], kept: Collection[str]) -> list[Any]:
    """Cases for `parametrize`, of which every run takes those kept."""
    return [case if case in kept else pytest.param(case, marks=pytest.mark.slow) for case in cases]


@lru_cache(maxsize=8)
def judged(name: str, mistake: str = "", kind: str = "float64") -> Conformance:
    return judge(engine(name, mistake, kind))


def codes(found: Conformance) -> set[str]:
    return {mistake.code for mistake in found.mistakes}


@pytest.mark.parametrize("name", some(RIGHT, QUICK))
def test_a_right_engine_has_no_mistake_and_its_order(name):
    found = judged(name)
    assert codes(found) == set()
    orders = [row.order for row in found.rows if row.order != "not judged"]
    assert len(orders) >= 10
    assert np.median(orders) == pytest.approx(ORDERS[name], abs=0.5)
    assert ("first_order" in {note.code for note in found.notes}) == (ORDERS[name] == 1.0)
    assert "unexplained" not in {note.code for note in found.notes}


@pytest.mark.parametrize("name", some([name for name in RIGHT if name != "explicit Euler"], {"RK4"}))
def test_a_right_engine_in_single_precision_has_no_mistake(name):
    found = judged(name, kind="float32")
    assert codes(found) == set()
    precisions = [row.precision for row in found.rows]
    assert 1e-9 < np.median(precisions) < 1e-7
    [turning] = [row for row in found.rows if row.case == "dzhanibekov_1e-9"]
    assert turning.order == "not judged" or ORDERS[name] == 1.0


@pytest.mark.parametrize("mistake", some(PUT_IN, OF_EACH_CODE))
@pytest.mark.parametrize("name", some(RIGHT, {"semi-implicit Euler"}))
def test_a_mistake_is_named(name, mistake):
    found = judged(name, mistake)
    assert codes(found) == expected(name, mistake)
    assert all(mistake.cases for mistake in found.mistakes)


@pytest.mark.parametrize("mistake", sampled(PUT_IN, every=16))
def test_a_mistake_is_named_in_single_precision(mistake):
    name = "semi-implicit Euler" if mistake == "momentum clamped" else "RK4"
    assert codes(judged(name, mistake, "float32")) == {MISTAKES[mistake]}


@pytest.mark.parametrize("kind", sampled(["float64", "float32"], every=2))
@pytest.mark.parametrize("name", sampled(ONE_SIDED, every=2))
def test_an_attitude_that_takes_the_rate_of_one_end_is_named(name, kind):
    found = judged(name, kind=kind)
    assert codes(found) == {"attitude_order"}
    assert name.rpartition(" ")[2] in found.mistakes[0].message


def test_rates_of_the_middle_of_a_step_are_of_first_order():
    def staggered(case, step):
        t_s = step * np.arange(1, round(case.duration / step) + 1)
        return t_s, case.truth(t_s).attitude_xyzw, case.truth(t_s - step / 2).body_rate

    found = judge(staggered)
    assert codes(found) == set()
    assert {note.code for note in found.notes} == {"first_order"}


def test_an_engine_without_error_is_not_judged():
    found = judge(exact)
    assert codes(found) == set()
    assert {row.order for row in found.rows} == {"not judged"}
    assert {row.error_rad for row in found.rows} == {"not judged"}
    assert "not judged" in str(found)


def test_the_start_may_be_returned_as_well_and_signs_of_quaternions_do_not_matter():
    def with_start(case, step):
        t_s, q, w = engine("RK4")(case, step)
        signs = np.where(np.arange(len(q) + 1) % 3 == 0, -1.0, 1.0)[:, np.newaxis]
        return np.append(0.0, t_s), signs * np.vstack([case.attitude_xyzw, q]), np.vstack([case.body_rate, w])

    assert judge(with_start).rows == judged("RK4").rows


@pytest.mark.slow
def test_steps_may_be_given():
    found = judge(engine("implicit midpoint"), steps=(30, 90, 270))
    assert np.median([row.order for row in found.rows if row.order != "not judged"]) == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize(
    "steps",
    [(20, 40, 90), 20, "abc", (0, 0, 0), (20, 20, 20), (20.5, 41, 82), (20, 50, 125), (-20, 40, -80), (np.nan,) * 3],
)
def test_steps_that_do_not_grow_by_one_factor_are_refused(steps):
    with pytest.raises(ParameterError, match=r"^steps: "):
        judge(engine("RK4"), steps=steps)


def test_an_engine_that_diverges_is_told_so():
    def diverges(case, step):
        t_s, q, w = engine("RK4")(case, step)
        w[len(w) // 2 :] = np.inf
        return t_s, q, w

    found = judge(diverges)
    assert {row.error_rad for row in found.rows} | {row.energy_drift for row in found.rows} >= {np.inf}
    assert codes(found) == {"unexplained"}
    assert len(found.mistakes[0].cases) == len(CASES)


@pytest.mark.parametrize(
    "wrong",
    sampled(
        [
            lambda t, q, w: (t, q * np.nan, w),
            lambda t, q, w: (t, q * np.nan, w * np.nan),
            lambda t, q, w: (t, 0 * q, w),
            lambda t, q, w: (t, np.roll(q, 1, axis=1), w),
            lambda t, q, w: (t, q, np.degrees(w)),
            lambda t, q, w: (t, q, 0 * w),
            lambda t, q, w: (t, q, np.where(np.arange(len(t))[:, np.newaxis] < 5, w, np.nan)),
        ],
        every=4,
    ),
)
def test_another_motion_or_none_is_a_mistake_that_is_unexplained(wrong):
    found = judge(lambda case, step: wrong(*engine("RK4")(case, step)))
    assert [mistake.code for mistake in found.mistakes] == ["unexplained"]
    assert found.notes == ()
    assert len(found.mistakes[0].cases) == len(CASES)
    assert "no mistake found" not in str(found)


def test_a_start_in_degrees_is_a_mistake():
    def in_degrees(case, step):
        return engine("RK4")(replace(case, body_rate=np.degrees(case.body_rate)), step)

    assert codes(judge(in_degrees)) == {"unexplained"}


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("first", sampled([200, 100], every=2))
def test_round_off_is_of_no_order(first):
    found = judge(engine("RK4", kind="float32"), (first, 2 * first, 4 * first))
    assert found.mistakes == ()
    assert found.notes == ()
    assert all(row.order == "not judged" or not 0.0 < row.order < 1.5 for row in found.rows)


def test_errors_that_grow_as_the_step_falls_are_a_mistake():
    def damped(case, step):
        t_s, q, w = engine("RK4")(case, step)
        return (
            t_s,
            quaternion.multiply(
                q, quaternion.exp(1e-6 * case.body_rate * case.period * np.arange(len(t_s))[:, np.newaxis])
            ),
            w,
        )

    assert codes(judge(damped)) == {"unexplained"}


def test_a_mistake_is_named_only_where_most_cases_show_it():
    def inverse(case, step):
        return engine("RK4")(replace(case, inertia=np.linalg.inv(case.inertia)), step)

    assert codes(judge(inverse)) == {"unexplained"}


def test_a_case_cannot_be_written():
    for case in CASES:
        arrays = [value for value in vars(case).values() if isinstance(value, np.ndarray)]
        assert len(arrays) == 7
        assert not any(array.flags.writeable for array in arrays)

    def in_place(case, step):
        rate = case.body_rate
        rate += step
        return exact(case, step)

    with pytest.raises(InputError, match=r"^tumble, .* read-only"):
        judge(in_place)


REFUSED: dict[str, Any] = {
    "times: .*steps": lambda t, q, w: (t[:-1], q[:-1], w[:-1]),
    "times: .*the steps": lambda t, q, w: (1.1 * t, q, w),
    "times: .*nan": lambda t, q, w: (np.nan * t, q, w),
    r"times: shape \(\)": lambda t, q, w: (1.0, q, w),
    "times: .*not numbers": lambda t, q, w: (t.astype(str), q, w),
    r"attitudes: shape \(162, 3\)": lambda t, q, w: (t, q[:, :3], w),
    "attitudes: .*equal rows": lambda t, q, w: (t, [*q.tolist()[:-1], [0.0]], w),
    "attitudes: complex": lambda t, q, w: (t, q + 0j, w),
    r"rates: shape \(161, 3\)": lambda t, q, w: (t, q, w[1:]),
    "NoneType": lambda t, q, w: None,
    "expected 3, got 2": lambda t, q, w: (t, q),
    "too many": lambda t, q, w: (t, q, w, w),
    "ZeroDivisionError": lambda t, q, w: (t, q, w / (1 // 0)),
}


@pytest.mark.parametrize("said", REFUSED)
def test_what_is_no_answer_for_every_step_is_refused(said):
    with pytest.raises(InputError, match=rf"^tumble, 162 steps of 0.0987654 s: .*{said}"):
        judge(lambda case, step: REFUSED[said](*exact(case, step)))


def test_everything_is_text_and_numbers():
    found = judged("semi-implicit Euler", "no gyroscopic term").to_dict()
    assert json.loads(json.dumps(found))["mistakes"][0]["code"] == "gyroscopic_term_missing"
    assert [row["case"] for row in found["rows"]] == [case.name for case in CASES]


@pytest.mark.parametrize("size", [1e-12, 1e-7, 1e-4])
def test_noise_of_a_smooth_series_is_found(size):
    t = np.linspace(0.0, 20.0, 1000)[:, np.newaxis]
    smooth = np.hstack([np.sin(3 * t), 1.0 / np.cosh(t - 10)])
    assert noise(smooth) < 1e-15
    random = np.random.default_rng(1).normal(scale=size, size=smooth.shape)
    assert noise(smooth + random) == pytest.approx(size, rel=0.25)


def test_the_example_in_another_language_is_right(tmp_path):
    compiler = shutil.which("g++") or shutil.which("clang++")
    if compiler is None:
        pytest.skip("there is no compiler of C++")
    built = tmp_path / "free_body"
    subprocess.run([compiler, "-O2", "-o", built, EXAMPLE], check=True)
    printed = subprocess.run([sys.executable, SCRIPT, built], capture_output=True, text=True, check=True).stdout
    assert "no mistake found" in printed
    orders = [float(order) for line in printed.splitlines()[1:13] if (order := line.split()[1]) != "not"]
    assert np.median(orders) == pytest.approx(4.0, abs=0.2)


PROGRAMS = {
    "": (2, "give a program"),
    "import sys; sys.exit(3)": (2, "tumble, 162 steps of 0.0987654 s: .*status 3"),
    "print('t_s,qx,qy,qz,qw,wx,wy,wz')": (2, "tumble, 162 steps of 0.0987654 s: .*t_s"),
    "print('0.1,0,0,0,1')": (2, "tumble, 162 steps of 0.0987654 s: .*times"),
    STILL: (1, "^$"),
}


@pytest.mark.parametrize("code", PROGRAMS)
def test_a_program_has_a_status_and_at_most_one_line_of_error(code):
    command = [sys.executable, SCRIPT, *([sys.executable, "-c", code] if code else [])]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    status, said = PROGRAMS[code]
    assert done.returncode == status
    assert len(done.stderr.splitlines()) == int(status == 2)
    assert re.search(said, done.stderr)
