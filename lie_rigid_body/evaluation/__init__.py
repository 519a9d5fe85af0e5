"""Worth of an attitude estimate: its errors, and their causes.

`attitude_error` defines the error. `evaluate` associates an estimate with the truth by stamps, makes the statistics,
looks for the lag and for mistaken conventions, and gives a `Score`. `nees` holds errors against covariances.
"""

from lie_rigid_body.evaluation.attitudes import AttitudeError, ExactTruth, SampledTruth, Truth, attitude_error
from lie_rigid_body.evaluation.consistency import Consistency, attitude_nees, nees
from lie_rigid_body.evaluation.cramer_rao_bound import CramerRaoBound
from lie_rigid_body.evaluation.estimate import Estimate
from lie_rigid_body.evaluation.score import Finding, Score
from lie_rigid_body.evaluation.scoring import evaluate
from lie_rigid_body.evaluation.statistics import Limits, Statistics, bias_error, time_to_converge

__all__ = [
    "AttitudeError",
    "Consistency",
    "CramerRaoBound",
    "Estimate",
    "ExactTruth",
    "Finding",
    "Limits",
    "SampledTruth",
    "Score",
    "Statistics",
    "Truth",
    "attitude_error",
    "attitude_nees",
    "bias_error",
    "evaluate",
    "nees",
    "time_to_converge",
]
