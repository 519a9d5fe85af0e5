"""Judge an engine in another language: ``python examples/engine/judge_program.py ./free_body``.

The program is run once for each case and step. It reads one line of JSON: the numbers of a case by their names, with
``step``, s, and ``steps``. It writes a line ``t_s,qx,qy,qz,qw,wx,wy,wz`` for each step, with the rate in the body's
axes; what follows a # is left out.

The status is 0 if no mistake was found, 1 if one was, and 2 if the program cannot be judged.
"""

import json
import subprocess
import sys

import numpy as np

from lie_rigid_body import InputError
from lie_rigid_body.conformance import judge


def program(*command):
    """Make an engine for `judge` of a program and its arguments."""

    def simulate(case, step):
        given = {**vars(case), "step": step, "steps": round(case.duration / step)}
        line = json.dumps(given, default=np.ndarray.tolist)
        done = subprocess.run(command, input=f"{line}\n", stdout=subprocess.PIPE, text=True, check=False)
        if done.returncode:
            raise RuntimeError(f"the program ends with status {done.returncode}")
        rows = np.loadtxt(done.stdout.splitlines(), delimiter=",", ndmin=2)
        return rows[:, 0], rows[:, 1:5], rows[:, 5:]

    return simulate


def main(*command):
    """Print what is found of a program, and return the status."""
    if not command:
        print("give a program: judge_program.py ./free_body", file=sys.stderr)
        return 2
    try:
        found = judge(program(*command))
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    print(found)
    return int(bool(found.mistakes))


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
