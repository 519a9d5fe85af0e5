"""Runs as arrays, for people who write and test attitude filters.

- `run`: the truth and the readings of a run, from a bag or into one;
- `readings`: what its sensors read;
- `ensemble`: simulated runs of a scenario, of one seed or of many;
- `truth`: the attitude between the samples of a run, from its scenario;
- `unavoidable`: the error that the noise of its sensors leaves to any filter;
- `recorded_estimate`: an estimate and its truth in a bag;
- `live_estimate`: the same from topics, of what is in `heard_truth` and `kept_estimate`.
"""

from lie_rigid_body.runs.ensemble import simulate
from lie_rigid_body.runs.readings import SensorArrays
from lie_rigid_body.runs.run import Run
from lie_rigid_body.runs.truth import ScenarioTruth

__all__ = [
    "Run",
    "ScenarioTruth",
    "SensorArrays",
    "simulate",
]
