"""Estimators: functions of a run that return attitudes, how they are named, and what they return."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from importlib import import_module
from typing import Any, Final, NamedTuple, TypeAlias

import numpy as np

from lie_rigid_body.errors import InputError, said
from lie_rigid_body.runs.run import Run
from lie_rigid_body.wording import shortened, shown

Estimator: TypeAlias = Callable[[Run], Any]

MENDED: Final = "mend it"
"""Remedy at the end of an error line about an estimator that cannot be imported."""


class Returned(NamedTuple):
    """What an estimator returned: stamps in ns, if any, attitudes (N, 4), and the covariance, if any, with its axes."""

    t_ns: Any
    attitude_xyzw: np.ndarray[Any, Any]
    covariance: Any = None
    covariance_axes: str = "world"


def estimator(name: str) -> Estimator:
    """The function of a name, in a module of the working directory or one that is installed.

    Parameters
    ----------
    name : str
        ``module:function``.

    Raises
    ------
    InputError
        If there is no such module or function.
    """
    module, _, function = name.partition(":")
    if os.getcwd() not in sys.path:
        sys.path.append(os.getcwd())  # an executable has its own folder there, not where it was started
    try:
        found = getattr(import_module(module), function, None)
    except (Exception, SystemExit) as error:
        raise InputError(f"estimator {shown(name)} cannot be imported: {shortened(said(error))}: {MENDED}") from None
    if not callable(found):
        raise InputError(f"estimator {shown(name)}: {shown(module)} has no function {shown(function)}: define it there")
    estimate: Estimator = found
    return estimate


def returned(result: Any) -> Returned:
    """Read what an estimator returned: attitudes, stamps and attitudes, or an object that has ``attitude_xyzw``.

    Raises
    ------
    InputError
        If it is none of these, with its shape.
    """
    if hasattr(result, "attitude_xyzw"):
        covariance = getattr(result, "covariance", None)
        axes = getattr(result, "covariance_axes", "world")
        found = Returned(getattr(result, "t_ns", None), np.asarray(result.attitude_xyzw), covariance, axes)
    elif isinstance(result, tuple) and len(result) == 2:
        found = Returned(result[0], np.asarray(result[1]))
    else:
        found = Returned(None, np.asarray(result))
    if found.attitude_xyzw.ndim != 2 or found.attitude_xyzw.shape[1] != 4:
        shape = f"{type(result).__name__} of shape {found.attitude_xyzw.shape}"
        raise InputError(f"the estimate is a {shape}: return attitudes (N, 4), or a tuple of stamps and attitudes")
    return found
