"""What checking a bag costs, beside reading its messages by the `mcap` library alone.

    python benchmarks/checking.py                      # ten minutes and an hour, a minute on an idle machine
    python benchmarks/checking.py --longest 600
    python benchmarks/checking.py --save               # also writes the table of docs/reference/costs.md

Processor times of all threads. Each bag is recorded and checked in a process of its own, between two turns of the
library, which reads a bag of the run's first minute. All loops are compiled before: a check loads from the cache what a
bag of its length pays for, as a user's does, and that is part of its time.
"""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

from bag_tasks import Run, Spent, alone, arguments, mean, messages_of, plain_reading, record, runs, tell
from lie_rigid_body import MovingChart, RigidBody, State
from lie_rigid_body.certificate import certify
from lie_rigid_body.recording.bag_reader import Bag


def compile_loops() -> bool:
    """Compile, or load, all that checking can use; whether numba is there to do it."""
    return MovingChart(RigidBody([1, 2, 3]), State([0, 0, 0, 1], [0, 1, 0])).compile()


def recorded(run: Run, path: Path) -> int:
    """Record a run, and return how many messages it has."""
    compile_loops()
    record(run.parameters, run.duration, path)
    return messages_of(path)


def ours(path: Path) -> Spent:
    """What checking a bag costs, s."""
    with Spent() as spent:
        assert certify(Bag(path)).passed
    return spent


def line(run: Run) -> tuple[str, ...]:
    """A line of the table."""
    with TemporaryDirectory() as folder:
        path = Path(folder, "bag.mcap")
        messages, _ = alone(recorded, run, path)
        before = plain_reading(run)
        spent, memory = alone(ours, path)
    plain, samples = mean(before, plain_reading(run)).cpu, run.rate * run.duration
    check = spent.each(messages).cpu
    print(
        f"{run.sensors}, {run.text}: {samples / spent.wall:.0f} samples a second; of processor time "
        f"{samples / spent.cpu:.0f}, and {messages / spent.cpu:.0f} messages; a message {check:.3f} µs, by the library "
        f"{plain:.3f} µs",
        flush=True,
    )
    return run.sensors, run.text, f"{messages / 1e6:.2f} million", f"{plain / check:.1f}", f"{memory:.0f} MiB"


def main() -> None:
    """Print the table."""
    given = arguments(__doc__)
    print("compiled" if compile_loops() else "on arrays")
    head = ("topics", "run", "messages", "times less processor time", "memory")
    tell("checking", [head, *map(line, runs(given.longest))], save=given.save)


if __name__ == "__main__":
    main()
