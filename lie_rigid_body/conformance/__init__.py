"""Physics engines judged by free rotations whose truth is proved: order, errors, drifts, and mistakes by name."""

from lie_rigid_body.conformance.cases import CASES, Case
from lie_rigid_body.conformance.judgement import Conformance, Mistake, Row, judge
from lie_rigid_body.conformance.program import program

__all__ = ["CASES", "Case", "Conformance", "Mistake", "Row", "judge", "program"]
