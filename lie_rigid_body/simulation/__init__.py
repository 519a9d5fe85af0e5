"""The one simulation: a scenario becomes samples at integer-nanosecond stamps.

A table of contents

- `sample_clock`: the stamps of samples, by their numbers;
- `samples`: states at their stamps;
- `segment`: a stretch of motion between two resets, and its text;
- `track`, `relay`: samples of one rate, computed ahead and handed out in order, across resets;
- `simulation`: the truth and the sensors side by side, across resets.
"""

from lie_rigid_body.simulation.sample_clock import SampleClock
from lie_rigid_body.simulation.samples import ImuSamples, MagnetometerSamples, Samples
from lie_rigid_body.simulation.segment import SOFTWARE, Segment
from lie_rigid_body.simulation.simulation import Simulation, Taken

__all__ = [
    "SOFTWARE",
    "ImuSamples",
    "MagnetometerSamples",
    "SampleClock",
    "Samples",
    "Segment",
    "Simulation",
    "Taken",
]
