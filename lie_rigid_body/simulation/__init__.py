"""The simulation of a scenario: samples at integer-nanosecond stamps.

Modules:

- `segment`: a stretch of motion between two resets, its JSON, the stamps of its samples, and when readings arrive;
- `samples`: states and readings at their stamps, queues of them, and the readings of one sensor in one segment;
- `loop`: the truth, the sensors and their faults together, across resets.
"""

from lie_rigid_body.simulation.loop import Motions, Simulation, SimulationStep, motions_of
from lie_rigid_body.simulation.samples import Samples, SensorSamples
from lie_rigid_body.simulation.segment import SOFTWARE, SampleClock, Segment

__all__ = [
    "SOFTWARE",
    "Motions",
    "SampleClock",
    "Samples",
    "Segment",
    "SensorSamples",
    "Simulation",
    "SimulationStep",
    "motions_of",
]
