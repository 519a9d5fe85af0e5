"""Runs as arrays, for people who write and test attitude filters.

- `run`: the truth and the readings of a run, from a bag; `bag_of_run`: into one;
- `readings`: what its sensors read;
- `ensemble`: simulated runs of a scenario, of one seed or of many, and runs without the truth;
- `truth`: the attitude at any time, as scenarios and poses tell it, and the error that the noise of the sensors leaves
  to any filter;
- `estimate`: what an estimator returns.
"""

from lie_rigid_body.evaluation.estimate import Estimate
from lie_rigid_body.runs.ensemble import simulate
from lie_rigid_body.runs.readings import SensorArrays
from lie_rigid_body.runs.run import Run
from lie_rigid_body.runs.truth import ScenarioTruth

__all__ = [
    "Estimate",
    "Run",
    "ScenarioTruth",
    "SensorArrays",
    "simulate",
]
