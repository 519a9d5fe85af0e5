"""A filter of the league."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import redirect_stdout
from dataclasses import dataclass, field
from functools import lru_cache
from importlib import import_module
from itertools import product
from pkgutil import iter_modules
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from league.readings import Array, Readings
from lie_rigid_body import Run

Setting = Mapping[str, float]

DEFAULTS: Final[Setting] = {}


@dataclass(frozen=True)
class Filter:
    """A filter, as its users would call it.

    Attributes
    ----------
    library : str
        Its name on PyPI.
    name : str
        The name that the library gives the filter.
    estimate : callable
        Of `Readings` and settings by name; returns N attitudes, world-from-body. Without a setting it runs at the
        library's defaults.
    grid : mapping of str to sequence of float
        Values of its settings that are tried in all combinations.
    sees_future : bool
        Whether an attitude rests on later readings too.
    advice : str
        What its users should set, or beware of.
    """

    library: str
    name: str
    estimate: Callable[..., Rotation]
    grid: Mapping[str, Sequence[float]] = field(default_factory=dict)
    sees_future: bool = False
    advice: str = ""

    @property
    def full_name(self) -> str:
        """Library and name."""
        return f"{self.library} {self.name}"

    def of_run(self, run: Run, **setting: float) -> tuple[NDArray[np.int64], Array]:
        """Attitudes that it gives of a run, with their stamps, as an estimator of the package returns them."""
        given = Readings.of(run)
        np.random.seed(1)  # noqa: NPY002 - what filters draw from
        with redirect_stdout(io.StringIO()):
            return given.t_ns, self.estimate(given, **setting).as_quat()

    def settings(self) -> Iterator[Setting]:
        """The defaults, and every point of the grid."""
        yield DEFAULTS
        if self.grid:
            for values in product(*self.grid.values()):
                yield dict(zip(self.grid, values, strict=True))


@lru_cache
def filters() -> tuple[Filter, ...]:
    """All filters whose libraries are installed: each module of `league.filters` has some."""
    return tuple(each for module in _modules() if not isinstance(module, str) for each in module.FILTERS)


def missing() -> list[str]:
    """The modules of `league.filters` whose libraries are not installed, so that their filters are left out."""
    return [module for module in _modules() if isinstance(module, str)]


def _modules() -> Iterator[Any]:
    for found in iter_modules(import_module("league.filters").__path__):
        try:
            yield import_module(f"league.filters.{found.name}")
        except ModuleNotFoundError:
            yield found.name
