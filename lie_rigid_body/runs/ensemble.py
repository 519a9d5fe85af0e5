"""Simulated runs: of one seed, or of many that share the truth."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable
from fractions import Fraction
from itertools import count
from pathlib import Path
from typing import overload

import numpy as np
from numpy.typing import ArrayLike

from lie_rigid_body.errors import InputError
from lie_rigid_body.mechanics import State
from lie_rigid_body.motion import Motion
from lie_rigid_body.parameters import exact_duration
from lie_rigid_body.runs.run import Run
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.scenario.parameter_file import gather
from lie_rigid_body.simulation import Simulation, motions_of


@overload
def simulate(
    scenario: str | Path | Scenario | None = None, *, duration: float, seeds: None = None, **parameters: object
) -> Run: ...


@overload
def simulate(
    scenario: str | Path | Scenario | None = None, *, duration: float, seeds: Iterable[int], **parameters: object
) -> tuple[Run, ...]: ...


def simulate(
    scenario: str | Path | Scenario | None = None,
    *,
    duration: float,
    seeds: Iterable[int] | None = None,
    **parameters: object,
) -> Run | tuple[Run, ...]:
    """Simulate a body and its sensors, with the same bits as in a bag of ``record``.

    Parameters
    ----------
    scenario : str, Path or Scenario, optional
        Name of a scenario of the package, path of a ROS 2 parameter file, or a scenario. None: the defaults.
    duration : float
        Every sample before this time after the first is simulated, s.
    seeds : iterable of int, optional
        Values of the parameter ``sensor_seed``, for as many runs. They share the truth, which is computed once.
    **parameters
        Parameters by their public names, over those of the scenario.

    Returns
    -------
    Run, or tuple of Run
        A tuple where seeds are given, in their order.

    Raises
    ------
    InputError
        If the duration is not a time, a name is unknown, or the parameters make no scenario.
    """
    length = exact_duration(_plain(duration), "duration", "duration=60.0")
    given = {**_parameters(scenario), **{name: _plain(value) for name, value in parameters.items()}}
    if seeds is None:
        return _run(Scenario.from_parameters(given), length, motions_of)
    if "sensor_seed" in parameters:
        raise InputError(f"sensor_seed {parameters['sensor_seed']!r} is given beside seeds: give one of them")
    shared = _SharedMotions()
    return tuple(_run(Scenario.from_parameters({**given, "sensor_seed": _plain(s)}), length, shared) for s in seeds)


def _run(scenario: Scenario, duration: Fraction, motions: Callable[[Scenario], Callable[[], Motion]]) -> Run:
    simulation = Simulation(scenario, motions=motions)
    taken = simulation.take_until(simulation.clock.last_ns_before(duration), sys.maxsize)
    return Run.of(taken, simulation.segment)


def _parameters(scenario: str | Path | Scenario | None) -> dict[str, object]:
    if isinstance(scenario, Scenario):
        return dict(scenario.parameters())
    if isinstance(scenario, Path):
        return gather(None, [scenario], [])
    if scenario is None or isinstance(scenario, str):
        return gather(scenario, [], [])
    raise InputError(f"scenario {scenario!r} is no name: give that of a scenario, a Path of a file, or a Scenario")


def _plain(value: object) -> object:
    """A number or an array of NumPy as those of Python."""
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value


class _SharedMotions:
    """The motions of one start for many simulations: each is computed by the first that asks."""

    def __init__(self) -> None:
        self._kept: list[_KeptMotion] = []

    def __call__(self, scenario: Scenario) -> Callable[[], Motion]:
        make, turns = motions_of(scenario), count()

        def motion() -> Motion:
            turn = next(turns)
            if turn == len(self._kept):
                self._kept.append(_KeptMotion(make()))
            return self._kept[turn]

        return motion


class _KeptMotion:
    """A motion that keeps its states, and gives them again for the same times."""

    def __init__(self, motion: Motion) -> None:
        self._motion = motion
        self._states: dict[bytes, State] = {}

    def expect(self, work: int) -> None:
        """Tell the motion of work that is to come; see `Motion`."""
        self._motion.expect(work)

    def at(self, t_ns: ArrayLike) -> State:
        """The states at the given times, ns."""
        key = np.asarray(t_ns).tobytes()
        if key not in self._states:
            self._states[key] = self._motion.at(t_ns)
        return self._states[key]
