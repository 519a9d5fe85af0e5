"""The definition of a campaign: a base scenario, what varies from run to run, how many runs, and the estimators."""

from __future__ import annotations

import inspect
import itertools
import json
import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import field, replace
from fractions import Fraction
from functools import cached_property, partial
from pathlib import Path
from typing import Any, Final

import numpy as np

from lie_rigid_body.campaign.distributions import Draw, Uniforms, distribution
from lie_rigid_body.estimates.estimators import Estimator, NamedFunction
from lie_rigid_body.estimates.programs import CommandEstimator, words
from lie_rigid_body.foundation.arrays import plain
from lie_rigid_body.foundation.errors import InputError, ParameterError
from lie_rigid_body.foundation.parameters import NS, Given, Parameter, Value, exact_duration
from lie_rigid_body.foundation.short_dataclass import short_dataclass
from lie_rigid_body.foundation.wording import printable, shown, suggestion
from lie_rigid_body.recording.poses import with_path
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.scenario.parameter_file import gather, read_yaml
from lie_rigid_body.scenario.parameter_table import BY_NAME
from lie_rigid_body.system.bounded_input import open_file
from lie_rigid_body.system.output_file import reason

TABLE: Final = "runs.parquet"
"""File of the table of all finished runs, written when no run is left to do."""
SCORES_TABLE: Final = "scores.parquet"
"""File of the table of scores, written beside that of the runs where estimators are compared."""
OF_TABLE: Final = b"lie_rigid_body.campaign"
"""Key, in the metadata of the table, of a JSON text with the campaign and the version that drew its runs."""
_NUMBERS: Final = (
    Parameter("runs", "int", 100, "Number of runs.", minimum=1, maximum=1_000_000),
    Parameter("seed", "int", 1, "Seed of all that is drawn.", minimum=0, maximum=2**64 - 1),
)
_KEYS: Final = ("runs", "seed", "duration", "scenario", "parameters", "vary", "estimator", "estimators", "gives")
GIVEN: Final = ("initial_attitude_xyzw",)
"""Parameters of the truth that a campaign may give to its estimators."""
_FUNCTION: Final = r"\w+(\.\w+)*:\w+"
"""Pattern of a function's name: module, colon, function."""
MAX_POINTS: Final = 100
"""Largest number of estimators and points of grids: each is called in every run, and has its place in the run's row."""
_KEYS_OF_ONE: Final = ("function", "command", "parameters", "grid")


@short_dataclass
class Campaign:
    """Runs of one scenario, each with parameters of its own.

    Parameters
    ----------
    runs : int
        How many, numbered from 0.
    seed : int
        From 0 to 2⁶⁴ − 1. With the number of a run and the name of a parameter it determines the value that is drawn.
    duration : float
        Length of each run, s.
    scenario : str, optional
        Name of a shipped scenario.
    parameters : mapping of str to object, optional
        Parameters that are the same in every run, over those of the scenario.
    vary : mapping of str to object, optional
        Parameters that are drawn, and from which distributions, as in the file.
    estimator : str, optional
        ``module:function`` that estimates the attitudes of a `Run`, to be scored in each run. It returns them
        world-from-body, scalar last, shape (N, 4), at the stamps of the IMU; or a tuple of stamps, ns, and attitudes.
    estimators : mapping of str to mapping, optional
        Estimators to compare, by their names: each a ``function`` with ``parameters`` and a ``grid`` of them, or a
        ``command``; see `EstimatorSpec`.
    gives : sequence of str, optional
        Parameters of the truth that the estimators are given beside the readings: ``initial_attitude_xyzw``, or none.

    Raises
    ------
    InputError
    """

    runs: int
    seed: int
    duration: float
    scenario: str | None = None
    parameters: Given = field(default_factory=dict, hash=False)
    vary: Given = field(default_factory=dict, hash=False)
    estimator: str | None = None
    estimators: Given = field(default_factory=dict, hash=False)
    gives: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        vars(self).update({name: plain(getattr(self, name)) for name in ("runs", "seed", "duration")})
        for number in _NUMBERS:
            number.read(getattr(self, number.name))
        self.exact_duration  # noqa: B018 refuses what is no duration
        if not isinstance(self.scenario, str | None):
            raise InputError(f"scenario: {shown(self.scenario)} is no name: give that of a shipped scenario")
        self._require_parameters()
        self._draws  # noqa: B018 refuses what is no distribution
        self._require_estimators()

    def _require_parameters(self) -> None:
        for place in ("parameters", "vary"):
            if not isinstance(getattr(self, place), Mapping):
                raise InputError(f"{place} is to be a mapping of parameter names: write '{place}:' and lines below it")
        for name in (*self.parameters, *self.vary):
            if name not in BY_NAME:
                raise InputError(f"there is no parameter {shown(name)}: {suggestion(str(name), BY_NAME, 'parameters')}")
            if name in self.parameters and name in self.vary:
                raise InputError(f"{name} is in parameters and in vary: leave it out of one of them")
            is_recorded = name == "record_path" and self.parameters.get(name)
            if is_recorded or (name in self.vary and BY_NAME[name].scope == "node"):
                raise InputError(
                    f"{name} is for the node: leave it out; a campaign keeps its bags in the folder of --out"
                )
        _require_plain("parameters and vary", [self.parameters, self.vary])

    def _require_estimators(self) -> None:
        if self.estimator is not None and not re.fullmatch(_FUNCTION, str(self.estimator)):
            raise InputError(f"estimator: {shown(self.estimator)} names no function: give module:function")
        if self.estimators and self.estimator is not None:
            raise InputError("estimator and estimators are given: give one of them")
        if any(one.grid for one in self.estimator_specs.values()) and self.runs < 2:
            raise InputError("runs: 1: the best point of a grid is scored on other runs: give 2 or more")
        if not isinstance(self.gives, list | tuple) or not {*map(str, self.gives)} <= {*GIVEN}:
            raise InputError(f"gives: {shown(self.gives)}: only [{', '.join(GIVEN)}] can be given, or leave it out")
        vars(self)["gives"] = tuple(self.gives)

    @classmethod
    def from_file(cls, path: str | Path) -> Campaign:
        """The campaign that a YAML file describes.

        Parameters
        ----------
        path : str or Path

        Raises
        ------
        InputError
            If the file cannot be read, or is no campaign.
        """
        content = read_yaml(path)
        if not isinstance(content, dict) or not {*_KEYS[:3]} <= {*content}:
            raise InputError(f"{path} is no campaign: give it at least 'runs:', 'seed:' and 'duration:'")
        if unknown := [key for key in content if key not in _KEYS]:
            raise InputError(f"{path}: there is no {shown(unknown[0])} in a campaign: give {', '.join(_KEYS)}")
        try:
            return cls(**{key: value for key, value in content.items() if value is not None})
        except InputError as error:
            raise InputError(f"{path}: {error}") from None

    @classmethod
    def from_table(cls, path: str | Path) -> Campaign:
        """The campaign that made a table of runs, with which each of them can be made again.

        Parameters
        ----------
        path : str or Path
            A ``runs.parquet``; no other file is needed.

        Raises
        ------
        InputError
            If the file cannot be read, or is no table of a campaign.
        """
        from pyarrow import ArrowException, parquet

        try:
            with open_file(path) as file:
                return cls(**json.loads((parquet.read_schema(file).metadata or {})[OF_TABLE])["campaign"])
        except InputError:
            raise
        except (ArrowException, OSError, ValueError, KeyError, TypeError, RecursionError) as error:
            what = f"{printable(str(path))} is no table of a campaign"
            raise InputError(f"{what}: {reason(error)}: give its {TABLE}") from None

    @cached_property
    def _draws(self) -> Mapping[str, Draw]:
        return {name: distribution(f"vary.{name}", given) for name, given in self.vary.items()}

    @cached_property
    def _base(self) -> Given:
        return {**gather(self.scenario, [], []), **self.parameters}

    @cached_property
    def estimator_specs(self) -> Mapping[str, EstimatorSpec]:
        """The estimators by their names; a single one has none, ``""``."""
        if self.estimator is not None:
            return {"": EstimatorSpec("", self.estimator)}
        if not isinstance(self.estimators, Mapping):
            raise InputError(
                "estimators is to be a mapping of names: write 'estimators:' and 'name: {function: …}' below"
            )
        found = dict(sorted((name, _estimator_spec(name, content)) for name, content in self.estimators.items()))
        count = sum(math.prod(len(values) for values in one.grid.values()) for one in found.values())
        if count > MAX_POINTS:
            raise InputError(f"estimators: {count} with the points of their grids: give at most {MAX_POINTS}")
        return found

    @cached_property
    def entries(self) -> tuple[EstimatorSpec, ...]:
        """Every estimator at every point of its grid: each is called in every run."""
        return tuple(entry for one in self.estimator_specs.values() for entry in one.points)

    @property
    def exact_duration(self) -> Fraction:
        """The duration as the decimal number that was written, s."""
        return exact_duration(self.duration, "duration", "60.0")

    def drawn(self, run: int) -> dict[str, Any]:
        """The values of the parameters that vary, for one run.

        Raises
        ------
        InputError
            If there is no run of that number.
        """
        if isinstance(run, bool) or not isinstance(run, int | np.integer) or not 0 <= run < self.runs:
            raise InputError(f"run {shown(run)} is none of this campaign: give a number from 0 to {self.runs - 1}")
        length = float(self.duration)
        return {name: draw(Uniforms(self.seed, int(run), name, length)) for name, draw in self._draws.items()}

    def scenario_of(self, run: int) -> Scenario:
        """The scenario of one run.

        Raises
        ------
        InputError
            If there is no run of that number, or naming the run, where its parameters make no scenario.
        """
        try:
            scenario = Scenario.from_parameters(with_path({**self._base, **self.drawn(run)}))
            scenario.require_until(math.ceil(self.exact_duration * NS) - 1)
            return scenario
        except ParameterError as error:
            raise InputError(f"run {run}: {error}") from None

    def varied(self, scenario: Scenario) -> dict[str, Value]:
        """The parameters that vary as the scenario of a run has them: in their own types, quaternions normalised."""
        found = {**dict(scenario.sensor_parameters), **scenario.parameters()}
        return {name: found[name] for name in self.vary}

    def to_json(self) -> str:
        """One line that says all of the campaign: campaigns with equal lines have equal runs."""
        content = {key: getattr(self, key) for key in _KEYS if getattr(self, key) or key in _KEYS[:6]}
        return json.dumps(content, sort_keys=True, ensure_ascii=False)


@short_dataclass
class EstimatorSpec:
    """One of the estimators of a campaign.

    Attributes
    ----------
    name : str
    function, command : str or None
        ``module:function``, or a program; one of them is given.
    parameters : dict of str to object
        Keyword arguments beside the run; at a point of its grid also those of that point.
    grid : dict of str to list
        Values that are tried of further ones, each with each of the others.
    """

    name: str
    function: str | None
    command: str | None = None
    parameters: Mapping[str, Any] = field(default_factory=dict)
    grid: Mapping[str, list[Any]] = field(default_factory=dict)

    @property
    def points(self) -> Iterator[EstimatorSpec]:
        """The estimator at each point of its grid; one without a grid once."""
        for values in itertools.product(*self.grid.values()):
            yield replace(self, parameters={**self.parameters, **dict(zip(self.grid, values, strict=True))})

    def require_parameters(self) -> None:
        """Refuse parameters that the function does not take, or lacks, and a program that is not there.

        Raises
        ------
        InputError
            Also if it cannot be imported.
        """
        if self.function is None:
            CommandEstimator(str(self.command)).require_program(f"estimators.{self.name}.")
            return
        function = NamedFunction(self.function).load()
        place = f"estimators.{self.name}" if self.name else "estimator"
        given = dict.fromkeys((*self.parameters, *self.grid))
        try:
            signature = inspect.signature(function)
        except ValueError:  # of a function in C that does not tell what it takes
            return
        try:
            signature.bind(None, **given)
        except TypeError as error:
            raise InputError(f"{place}: {self.function}: {error}: give the parameters that it takes") from None

    def load(self) -> Estimator:
        """The estimator as a function of a run.

        Raises
        ------
        InputError
            If it cannot be imported.
        """
        if self.command is not None:
            return CommandEstimator(self.command)
        found = NamedFunction(str(self.function)).load()
        return partial(found, **self.parameters) if self.parameters else found


def _estimator_spec(name: object, content: object) -> EstimatorSpec:
    if not (isinstance(name, str) and name and name.isprintable()):
        raise InputError(f"estimators: {shown(name)} is no name: give printable characters")
    place = f"estimators.{name}"
    if not isinstance(content, Mapping):
        raise InputError(f'{place} is to be a mapping: give {{function: "module:function"}}')
    if unknown := [key for key in content if key not in _KEYS_OF_ONE]:
        raise InputError(f"{place}: there is no {shown(unknown[0])}: give {', '.join(_KEYS_OF_ONE)}")
    function = content.get("function")
    command = content.get("command")
    if (function is None) == (command is None):
        raise InputError(f"{place}: give function or command, one of them")
    if function is not None and not re.fullmatch(_FUNCTION, str(function)):
        raise InputError(f"{place}.function: {shown(function)} names no function: give module:function")
    parameters = _mapping(f"{place}.parameters", content.get("parameters"))
    grid = _mapping(f"{place}.grid", content.get("grid"))
    if command is not None and (not isinstance(command, str) or not words(command) or parameters or grid):
        raise InputError(
            f"{place}.command: {shown(command)}: a program takes its parameters in its line: give a text, with its "
            "quotations closed, and no parameters or grid"
        )
    for key, values in grid.items():
        if not (isinstance(values, list | tuple) and values) or key in parameters:
            raise InputError(
                f"{place}.grid.{key}: {shown(values)}: give a list of values of a name that is not in parameters"
            )
    _require_plain(place, [parameters, grid])
    return EstimatorSpec(name, function, command, parameters, {key: [*values] for key, values in sorted(grid.items())})


def _require_plain(place: str, value: object) -> None:
    """Refuse what a line of JSON cannot hold."""
    try:
        json.dumps(value, allow_nan=False)
    except (TypeError, ValueError):
        raise InputError(
            f"{place}: NaN, infinity, dates and bytes are not allowed: give finite numbers, texts, lists and mappings"
        ) from None


def _mapping(place: str, value: object) -> dict[str, Any]:
    given = {} if value is None else value
    if not isinstance(given, Mapping) or not all(isinstance(key, str) and key.isidentifier() for key in given):
        raise InputError(f"{place}: {shown(value)} is no mapping of names of keyword arguments: give one")
    return dict(given)
