"""What the tests of bags share."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from lie_rigid_body.messages.batch import BatchEncoder
from lie_rigid_body.recording.bag_writer import BagWriter
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Samples, Simulation, Taken

MakeBag = Callable[..., Path]


def write_samples(bag: BagWriter, scenario: Scenario, samples: Samples) -> None:
    bag.write(BatchEncoder(scenario).encode(Taken(samples, None, None)))


def write_bag(path: Path, count: int = 100, batch: int = 1024, **parameters: object) -> Path:
    """Write samples of a closed-form scenario with the given parameters."""
    scenario = Scenario.from_parameters({"motion": "closed_form", **parameters})
    simulation = Simulation(scenario)
    with BagWriter(path, stamped_twist=scenario.stamped_twist) as bag:
        bag.begin_segment(simulation.segment)
        while simulation.next_sample < count:
            write_samples(bag, scenario, simulation.take(min(batch, count - simulation.next_sample)))
    return path
