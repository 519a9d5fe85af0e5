"""What recording in bulk costs, simulation included, beside the `mcap` library's writer alone on the same messages.

    python benchmarks/recording.py                     # ten minutes and an hour, a minute on an idle machine
    python benchmarks/recording.py --longest 600
    python benchmarks/recording.py --save              # also writes the table of docs/reference/costs.md

Each run is recorded in a process of its own, between two turns of the library, which writes the run's first minute:
what a message costs it does not depend on how many there are. Neither the simulation nor the encoding of messages is
charged to the library's `add_message`. The simulation runs compiled where numba is installed, and compiling is over
before.
"""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

from bag_tasks import Run, Spent, alone, arguments, mean, messages_of, plain_writing, record, runs, tell
from lie_rigid_body import MovingChart, RigidBody, State


def compile_all() -> None:
    """Compile what a long run is computed by, or load it."""
    MovingChart(RigidBody([1, 2, 3]), State([0, 0, 0, 1], [0, 1, 0])).compile()


def ours(run: Run) -> tuple[int, Spent]:
    """Messages of a run, and what one costs, µs."""
    compile_all()
    with TemporaryDirectory() as folder:
        path = Path(folder, "bag.mcap")
        with Spent() as spent:
            record(run.parameters, run.duration, path)
        messages = messages_of(path)
    return messages, spent.each(messages)


def line(run: Run) -> tuple[str, ...]:
    """A line of the table."""
    before = plain_writing(run)
    (messages, bulk), memory = alone(ours, run)
    plain = mean(before, plain_writing(run))
    print(f"{run.sensors}, {run.text}: a message {bulk.wall:.3f} µs, by the library {plain.wall:.3f} µs", flush=True)
    ratios = f"{plain.wall / bulk.wall:.1f}", f"{plain.cpu / bulk.cpu:.1f}"
    return run.sensors, run.text, f"{messages / 1e6:.2f} million", *ratios, f"{memory:.0f} MiB"


def main() -> None:
    """Print the table."""
    given = arguments(__doc__)
    head = ("topics", "run", "messages", "times faster", "of processor time", "memory")
    compile_all()
    tell("recording", [head, *map(line, runs(given.longest))], save=given.save)


if __name__ == "__main__":
    main()
