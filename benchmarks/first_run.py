"""What a first long run costs, with the process that compiles, with compiling in the run itself, and without numba.

    python benchmarks/first_run.py                     # some ten minutes on an idle machine
    python benchmarks/first_run.py --seconds 600

Each command runs in a process of its own, twice: with an empty folder of compiled code, and with what the first left
there. The figures are processor time, which a loaded machine changes little: that of the thread that works, with that
of a compiler it waits for, and that of everything.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage
from tempfile import TemporaryDirectory
from typing import Final

HOW: Final = {
    "another process": "",
    "the run itself": "from lie_rigid_body.compilation import work; work.started = lambda *function: None",
    "without numba": "import sys; sys.modules['numba'] = None",
}
"""Where the compiler runs, each with what makes it so."""
RUN: Final = """
import json, sys, time
from lie_rigid_body.__main__ import main
from lie_rigid_body.compilation import work

def waited(load):
    def loading(*function):
        before = time.process_time() - time.thread_time()
        found = load(*function)
        spent[0] += time.process_time() - time.thread_time() - before
        return found
    return loading

spent = [0.0]
work.loaded = waited(work.loaded)
assert main(sys.argv[1:]) == 0
json.dump(time.thread_time() + spent[0], sys.stderr)
"""
SENSORS: Final = ["-p", "imu_rate:=1000.0", "-p", "sensor_grade:=mems"]


def cost(how: str, command: list[str], folder: Path) -> tuple[float, float]:
    """Processor time of the thread that works, with what it waits for, and of everything, s."""
    before, code = getrusage(RUSAGE_CHILDREN), f"{HOW[how]}\n{RUN}"
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(folder / "cache")}
    command = [sys.executable, "-c", code, *command]
    done = subprocess.run(command, env=environment, cwd=folder, capture_output=True, text=True, check=True)
    after = getrusage(RUSAGE_CHILDREN)
    return json.loads(done.stderr), after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seconds", type=float, default=3600.0, help="of the runs (default: %(default)g)")
    duration = ["-p", "rate:=1000.0", "--quiet", "--force", "--duration", str(parser.parse_args().seconds)]
    commands = {
        "record": ["record", "plain.mcap", *duration],
        "check": ["check", "plain.mcap"],
        "record with an IMU": ["record", "imu.mcap", *SENSORS, *duration],
        "check with an IMU": ["check", "imu.mcap"],
    }
    print(f"| first run | {' | '.join(HOW)} |")
    with TemporaryDirectory() as made:
        for name, command in commands.items():
            cells = []
            for how in HOW:
                with TemporaryDirectory() as cache:
                    (Path(made) / "cache").unlink(missing_ok=True)
                    (Path(made) / "cache").symlink_to(cache)
                    first, later = (cost(how, command, Path(made)) for _ in range(2))
                cells.append(f"{first[0]:.1f} s of {first[1]:.1f} s, later {later[0]:.1f} s")
            print(f"| {name} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
