"""The benchmark's contenders are set up as they should be: their errors are finite, and fall with their steps."""

from __future__ import annotations

import json
from decimal import Decimal, localcontext
from functools import cache
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pytest

from lie_rigid_body.motion.moving_chart import DEFAULT_METHOD
from peers import registry
from peers.contender import Contender, step_text
from peers.measurement import Row, ahead, measure
from peers.ours import SHOWN
from peers.pictures import drift
from peers.table import MARK, replaced, short_table
from peers.task import LONG, NS, TASKS, Task
from peers.truth import errors, truth
from sampled import sampled

ROOT = Path(__file__).parents[2]

BRIEF = Task("brief", "two attitudes", np.array([NS, 2 * NS]), np.arange(2))
DENSE = Task("dense", "a second at 1 kHz", np.arange(1, 1001) * (NS // 1000), np.array([131, 344, 475, 688, 901, 999]))

ROUND_OFF = 1e-11
"""What adds up in 2 s at short steps is less than this, rad."""

ORDERS = {
    "ours, moving chart rkmk4": 4,
    "MuJoCo, Euler": 1,
    "MuJoCo, implicit": 1,
    "MuJoCo, implicitfast": 1,
    "MuJoCo, RK4": 4,
    "Drake, discrete": 1,
    "Drake, continuous RK5": 5,
    "jaxlie, RKMK4": 4,
    "DART, free joint": 1,
    "PyBullet, multibody": 1,
    "PyBullet, rigid body": 1,
}
PEERS = (
    "FRB, exact",
    "FRB, Gauss of order 10",
    "van Zon, Schofield",
    "Orekit, TorqueFree",
    "diffrax, Tsit5",
    "diffrax, Dopri8",
    "Drake, continuous RK3",
    "SciPy, solve_ivp RK45",
    "SciPy, solve_ivp DOP853",
    "SciPy, odeint (LSODA)",
    "SciPy, ode dop853",
)
FAMILIES = ("ours, closed form", *(f"ours, moving chart {name}" for name in SHOWN), *list(ORDERS)[1:], *PEERS)


@cache
def of_family(family: str, task: Task = BRIEF) -> list[tuple[float, float]]:
    """Size of the setting and largest error of each contender of a family, the coarsest first."""
    own = [contender for contender in registry.contenders(task) if contender.family == family]
    if not own:
        pytest.skip(f"not installed: {' '.join(registry.missing())}")
    return sorted(((each.size, float(errors(task, each.run()).max())) for each in own), reverse=True)


def test_the_truth_is_that_of_another_method():
    points = json.loads((ROOT / "test/data/torque_free_truth.json").read_text())["asymmetric"]["truth"]
    known = {point["t_ns"]: point["attitude_xyzw"] for point in points}
    shared = sorted(known.keys() & truth().keys())
    assert shared == [10 * NS, 1000 * NS]
    with localcontext() as context:
        context.prec = 50
        for t in shared:
            pairs = list(zip(map(Decimal, known[t]), truth()[t], strict=True))
            sign = Decimal(1).copy_sign(sum(a * b for a, b in pairs))
            assert max(abs(a - sign * b) for a, b in pairs) < Decimal("1e-39")


def test_the_truth_has_every_judged_instant():
    assert all(set(task.judged_ns) <= truth().keys() for task in TASKS)


def test_the_angle_to_the_truth_is_that_of_the_rotation_between():
    angles = np.array([1e-9, 3.0])
    x, y, z, w = np.array([[float(c) for c in truth()[t]] for t in BRIEF.judged_ns]).T
    s, c = np.sin(angles / 2), np.cos(angles / 2)
    turned = np.stack([c * x + s * w, c * y + s * z, c * z - s * y, c * w - s * x], axis=1)
    np.testing.assert_allclose(errors(BRIEF, -7.0 * turned), angles, rtol=1e-6)


@pytest.mark.parametrize("family", sampled(FAMILIES, every=8))
def test_errors_are_finite_and_fall(family):
    (_, coarsest), *_, (_, finest) = [(0.0, np.inf), *of_family(family)]
    assert finest < 1e-2
    assert finest <= max(coarsest, ROUND_OFF)


@pytest.mark.parametrize(("family", "order"), ORDERS.items())
def test_a_fixed_step_has_its_order(family, order):
    used = [(h, e) for h, e in of_family(family) if ROUND_OFF < e < 0.2]
    if family == "Drake, continuous RK5":  # longer steps are too coarse for its order to show, shorter at round-off
        used = [(h, e) for h, e in of_family(family) if 0.005 <= h <= 0.02]
    if family.startswith("MuJoCo"):
        major, minor = map(int, version("mujoco").split(".")[:2])
        order = order_in_mujoco(family, (major, minor))
    steps, errors_of_them = np.log(np.array(used)).T
    slope = np.polyfit(steps, errors_of_them, 1)[0]
    assert len(used) >= 3
    assert slope == pytest.approx(order, abs=0.25)


def order_in_mujoco(family: str, release: tuple[int, int]) -> int:
    """The order on a body that turns: RK4 had 2 before MuJoCo 4, implicitfast has had 1 instead of 2 since 3.11."""
    if family == "MuJoCo, RK4" and release < (4, 0):
        return 2
    return 2 if family == "MuJoCo, implicitfast" and release < (3, 11) else ORDERS[family]


def test_the_closed_form_is_exact():
    assert of_family("ours, closed form")[0][1] < 2e-15


def test_a_spline_through_exact_attitudes_errs_between_them():
    pairs = of_family("SciPy, RotationSpline", DENSE)
    steps, errors_of_them = np.log(np.array([(h, e) for h, e in pairs if h >= 0.01])).T
    assert np.polyfit(steps, errors_of_them, 1)[0] > 3.0


def test_the_default_moving_chart_is_the_unit():
    for task in (BRIEF, DENSE):
        assert [c.family for c in registry.contenders(task) if c.unit] == [f"ours, moving chart {DEFAULT_METHOD}"]


def test_who_is_neither_matched_in_accuracy_nor_in_cost_is_ahead():
    def row(ours: bool, error: float, cost: float) -> Row:
        return Row(Contender("", "", 0.0, lambda: np.empty(0), ours), np.array([0.0, error]), cost)

    ours = [row(True, 1e-3, 1.0), row(True, 1e-9, 3.0)]
    behind = [row(False, 1e-3, 1.0), row(False, 1e-6, 3.0), row(False, 1e-2, 2.0)]
    before = [row(False, 1e-6, 2.0), row(False, 1e-10, 9.0), row(False, 1.0, 0.5)]
    assert ahead([*ours, *behind, *before]) == before


def test_what_would_take_too_long_is_not_begun():
    run = next(c for c in registry.contenders(BRIEF) if c.family == "ours, closed form")
    slow = Contender("slow", "", 0.0, lambda: pytest.fail("it ran"))
    rows = measure(BRIEF, [run, slow], {("slow", ""): 1e9})
    assert [row.contender for row in rows] == [run]


def test_curves_that_lie_under_another_are_drawn_as_one_and_named():
    def row(family: str, error: float) -> Row:
        contender = Contender(family, "1 ms", 1e-3, lambda: np.empty(0), ours=True)
        return Row(contender, np.full(len(LONG.judged_ns), error), 1.0)

    names = [f"ours, moving chart {name}" for name in ("rkmk4", "dmv2", "dmv6", "dmv8", "dmv20")]
    rows = [row("ours, closed form", 2e-16), *map(row, names, [1e-9, 1e-4, 1e-16, 1.1e-16, 2e-16])]
    figure = drift(rows)
    [legend] = figure.legends
    told = [text.get_text() for text in legend.get_texts()]
    assert told == [
        "ours, closed form, 1 ms",
        "ours, moving chart rkmk4, 1 ms",
        "ours, moving chart dmv2, 1 ms",
        "ours, moving chart dmv6 … dmv20, 1 ms",
    ]
    assert len([line for line in figure.axes[0].get_lines() if line.get_marker() != "None"]) == len(told)


def test_only_the_table_of_a_page_is_exchanged():
    fast = next(c for c in registry.contenders(BRIEF) if c.family == "ours, closed form")
    unit = Contender("unit", "", 0.0, fast.run, ours=True, unit=True)
    rows = measure(BRIEF, [fast, unit], {})
    first, last = (MARK.format(edge=edge, name="brief") for edge in ("begin", "end"))
    page = f"before\n{first}\nold\n{last}\nafter\n"
    new = replaced(page, BRIEF, rows)
    assert new.startswith(f"before\n{first}\n\n| ")
    assert new.endswith(f".\n\n{last}\nafter\n")
    assert "old" not in new
    assert replaced(new, BRIEF, rows) == new
    assert all(len(line) == len(short_table(rows).splitlines()[0]) for line in short_table(rows).splitlines())


@pytest.mark.parametrize(
    ("page", "names"),
    [
        ("benchmarks.md", ["software", *(task.name for task in TASKS)]),
        ("reference/costs.md", ["recording", "checking", "campaign"]),
    ],
)
def test_the_page_has_a_place_for_every_table(page, names):
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    for name in names:
        assert all(text.count(MARK.format(edge=edge, name=name)) == 1 for edge in ("begin", "end"))


@pytest.mark.parametrize(("step", "text"), [(0.002, "2 ms"), (0.0005, "500 µs"), (2.0**-7, "2⁻⁷ s"), (0.1, "100 ms")])
def test_steps_for_the_eye(step, text):
    assert step_text(step) == text
