"""Estimators: functions of a run that return an estimate, and how they are named."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from importlib import import_module
from typing import Any, Final, TypeAlias

from lie_rigid_body.errors import InputError, said
from lie_rigid_body.runs.run import Run
from lie_rigid_body.wording import shortened, shown

Estimator: TypeAlias = Callable[[Run], Any]

MENDED: Final = "mend it"
"""Remedy at the end of an error line about an estimator that cannot be imported."""


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
