"""Physics engines judged by free rotations whose truth is proved: order, errors, drifts, and mistakes by name."""

from lie_rigid_body.conformance.cases import CASES, EngineCase
from lie_rigid_body.conformance.judgement import Conformance, EngineMistake, EngineRow, judge

__all__ = ["CASES", "Conformance", "EngineCase", "EngineMistake", "EngineRow", "judge"]
