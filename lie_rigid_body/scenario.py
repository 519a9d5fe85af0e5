"""The scenario: everything that determines a run, frozen, and validated once."""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from decimal import ROUND_FLOOR, Context
from typing import Final, cast

import numpy as np
from numpy.typing import NDArray

from lie_rigid_body.errors import ParameterError
from lie_rigid_body.lie import so3
from lie_rigid_body.mechanics import RigidBody, State
from lie_rigid_body.motion import METHODS, ClosedForm, Motion, MovingChart
from lie_rigid_body.motion.moving_chart import DEFAULT_MAX_STEP, DEFAULT_METHOD
from lie_rigid_body.parameters import MAX_EPOCH_NS, Parameter, Value

LARGEST_TURN_PER_STEP: Final = 1.0
"""rad: a moving chart that turned farther in one step would go where its Taylor expansion means nothing."""

PARAMETERS: Final = (
    Parameter(
        "inertia",
        "double_array",
        (1.0, 2.0, 3.0),
        "Inertia about the mass centre, kg m^2: 3 principal moments along the body axes, or ixx ixy ixz iyy iyz izz.",
        lengths=(3, 6),
    ),
    Parameter(
        "initial_attitude_xyzw",
        "double_array",
        (0.0, 0.0, 0.0, 1.0),
        "Unit quaternion, scalar last, taking body vectors to world vectors at the start.",
        lengths=(4,),
    ),
    Parameter(
        "initial_body_rate",
        "double_array",
        (0.01, 1.0, 0.01),
        "Angular velocity in the body frame at the start, rad/s.",
        lengths=(3,),
    ),
    Parameter(
        "rate",
        "double",
        100.0,
        "Samples per second, from one in eleven days to one per nanosecond.",
        minimum=1e-6,
        maximum=1e9,
    ),
    Parameter(
        "motion",
        "string",
        "moving_chart",
        "How the state moves: moving_chart integrates Euler's equations, closed_form evaluates the exact solution.",
        choices=("moving_chart", "closed_form"),
    ),
    Parameter("method", "string", DEFAULT_METHOD, "Stepper of the moving chart.", choices=tuple(METHODS)),
    Parameter(
        "max_step",
        "double",
        DEFAULT_MAX_STEP,
        "Largest step of the moving chart, s.",
        minimum=1e-9,
        maximum=1e6,
    ),
    Parameter("world_frame", "string", "world", "Name of the inertial frame of the pose."),
    Parameter("body_frame", "string", "base_link", "Name of the body frame of the twist."),
    Parameter("stamped_twist", "bool", True, "Publish TwistStamped (true) or bare Twist (false)."),
    Parameter(
        "epoch_ns",
        "int",
        0,
        "Stamp of the first sample, ns; 0 in the node means the time of start.",
        minimum=0,
        maximum=MAX_EPOCH_NS,
    ),
    Parameter("record_path", "string", "", "The node also writes this MCAP file; empty: it writes none."),
)
"""Every parameter, in the order in which they are shown."""

_BY_NAME: Final = {parameter.name: parameter for parameter in PARAMETERS}


@dataclass(frozen=True)
class Scenario:
    """A body, its start and the way it is sampled. Build it with `from_parameters`, which validates.

    Attributes carry the names, types and units of the parameters (see ``PARAMETERS``).
    """

    inertia: tuple[float, ...]
    initial_attitude_xyzw: tuple[float, ...]
    initial_body_rate: tuple[float, ...]
    rate: float
    motion: str
    method: str
    max_step: float
    world_frame: str
    body_frame: str
    stamped_twist: bool
    epoch_ns: int

    @classmethod
    def from_parameters(cls, given: Mapping[str, object] | None = None) -> Scenario:
        """The scenario of the given parameters, the rest at their defaults, validated as a whole.

        Parameters
        ----------
        given : mapping of str to object, optional
            Values as a YAML file or a ROS parameter gives them.

        Returns
        -------
        Scenario

        Raises
        ------
        ParameterError
            Naming the parameter, its value, its limit and the remedy.
        """
        values = read_parameters(given or {})
        scenario = cls(**{f.name: values[f.name] for f in fields(cls)})  # type: ignore[arg-type]
        scenario._validate()
        return scenario

    def parameters(self) -> dict[str, Value]:
        """Names and values, in the order of the table."""
        return cast(dict[str, Value], asdict(self))

    def body(self) -> RigidBody:
        """The body of this scenario."""
        return RigidBody(self.inertia)

    def start(self) -> State:
        """The state at the start."""
        return State(self.initial_attitude_xyzw, self.initial_body_rate)

    def make_motion(self) -> Motion:
        """A fresh motion from the start."""
        if self.motion == "closed_form":
            return ClosedForm(self.body(), self.start())
        return MovingChart(self.body(), self.start(), method=self.method, max_step=self.max_step)

    def _validate(self) -> None:
        for name in ("world_frame", "body_frame"):
            _require_frame_name(name, getattr(self, name))
        with np.errstate(all="ignore"):  # what goes wrong is said below
            body, start = self.body(), self._valid_start()
            _require_ordinary_inertia(body)
            _require_ordinary_motion(body, start)
        if self.motion == "moving_chart":
            self._require_small_steps(body, start)

    def _valid_start(self) -> State:
        try:
            return self.start()
        except ParameterError as error:
            name = f"initial_{error.name}"
            raise ParameterError(name, str(error).removeprefix(f"{error.name}: ")) from None

    def _require_small_steps(self, body: RigidBody, start: State) -> None:
        fastest = math.sqrt(2.0 * float(body.kinetic_energy(start)) / float(body.principal_moments[0]))
        step = min(self.max_step, 1.0 / self.rate)
        if fastest * step > LARGEST_TURN_PER_STEP:
            raise ParameterError(
                "max_step",
                f"{self.max_step:g} s lets the body turn by up to {fastest * step:.3g} rad in one step, the limit is "
                f"{LARGEST_TURN_PER_STEP:g}: {_shorter(LARGEST_TURN_PER_STEP / fastest)}use closed_form",
            )


def _shorter(longest: float) -> str:
    """The remedy for too long a step, if there is one: rounded down, so that it is not refused itself."""
    step = float(Context(prec=3, rounding=ROUND_FLOOR).create_decimal_from_float(longest))
    return f"give at most {step:g} s, or " if step >= _BY_NAME["max_step"].minimum else ""


def read_parameters(given: Mapping[str, object]) -> dict[str, Value]:
    """Every parameter's value: the given ones in their own types, the rest at their defaults.

    Parameters
    ----------
    given : mapping of str to object

    Returns
    -------
    dict of str to value

    Raises
    ------
    ParameterError
        If a name is unknown or a value is not of its parameter's type, length, range or choice.
    """
    for name in given:
        if name not in _BY_NAME:
            near = difflib.get_close_matches(str(name), _BY_NAME, n=1)
            hint = f"did you mean {near[0]}?" if near else f"the parameters are {', '.join(_BY_NAME)}"
            raise ParameterError(str(name), f"no such parameter: {hint}")
    return {p.name: p.read(given[p.name]) if p.name in given else p.default for p in PARAMETERS}


def _require_ordinary_inertia(body: RigidBody) -> None:
    if not (_is_ordinary(body.principal_moments) and _is_ordinary(1.0 / body.principal_moments)):
        raise ParameterError(
            "inertia",
            f"principal moments {_listed(body.principal_moments)}, or their inverses, leave the range of double "
            "precision: give moments between 1e-300 and 1e300 kg m²",
        )


def _require_ordinary_motion(body: RigidBody, start: State) -> None:
    """Energy and momentum in the range of double precision; an energy may be so small that it is 0."""
    energy, momentum = body.kinetic_energy(start), so3.norm(body.body_momentum(start))
    if not all(value == 0.0 or _is_ordinary(value) for value in (energy, momentum)):
        raise ParameterError(
            "initial_body_rate",
            f"{_listed(start.body_rate)} rad/s gives the energy {energy:g} J and the momentum {momentum:g} kg m²/s, "
            "which leave the range of double precision: give an ordinary rate, or zeros",
        )


def _is_ordinary(values: NDArray[np.float64]) -> bool:
    """Whether positive numbers are finite, and not so small that they lose digits."""
    return bool(np.all(np.isfinite(values) & (values >= np.finfo(np.float64).tiny)))


def _listed(values: NDArray[np.float64]) -> str:
    return ", ".join(f"{value:g}" for value in values)


def _require_frame_name(name: str, value: str) -> None:
    if not value or value.startswith("/") or any(c.isspace() or not c.isprintable() for c in value):
        raise ParameterError(
            name, f"{value!r} is not a frame name: give a word without spaces that does not begin with a slash"
        )
