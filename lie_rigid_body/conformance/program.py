"""An engine in another language as a program: a case as JSON in, states as CSV out."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Sequence

import numpy as np

from lie_rigid_body.conformance.cases import EngineCase
from lie_rigid_body.conformance.results import Simulate
from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.foundation.wording import MAX_LINE, shortened, shown


def program(*command: str) -> Simulate:
    """A program as an engine for `judge`: it is run once for each case and step.

    Parameters
    ----------
    *command : str
        The program and its arguments. Its standard input is one line of JSON: the numbers of an `EngineCase` by their
        names, ``step``, s, and ``steps``. Its standard output is a line ``t_s,qx,qy,qz,qw,wx,wy,wz`` for each step, with the
        rate in the body's axes; a line that begins with # is left out.

    Returns
    -------
    callable
        It raises `InputError` where the program fails, or writes other lines.
    """

    def simulate(case: EngineCase, step: float) -> tuple[Array, Array, Array]:
        given = {**vars(case), "step": step, "steps": round(case.duration / step)}
        rows = _run(command, json.dumps(given, default=np.ndarray.tolist))
        return rows[:, 0], rows[:, 1:5], rows[:, 5:]

    return simulate


def _run(command: Sequence[str], given: str) -> Array:
    try:
        done = subprocess.run(command, input=f"{given}\n", capture_output=True, text=True, check=True)
        return np.loadtxt(done.stdout.splitlines(), delimiter=",", ndmin=2)
    except (OSError, subprocess.CalledProcessError, ValueError) as error:
        raise InputError(
            f"{shown(command[0])}: {shortened(str(error), MAX_LINE // 2)}: let it read a line of JSON, write lines "
            "t_s,qx,qy,qz,qw,wx,wy,wz and end with status 0"
        ) from None
