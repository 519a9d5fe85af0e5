"""Diagnosis of an attitude filter that can be run again: its mistakes by repairs, its abilities by probes.

A filter is run on readings of perfect sensors. Where it errs, its readings and its estimate are repaired from outside,
and the repair that makes the error vanish names the mistake.

- `course`: the motions, and what sensors read of them;
- `repairs`: changes of the readings, and runs with them; those of the estimate are `lie_rigid_body.evaluation.causes`;
- `search`: which repairs are tried, and the one rule by which they are chosen;
- `probes`: what the filter can do, with one thing at a time in its way;
- `examination`: all of it in order, and what is said.
"""

from lie_rigid_body.diagnosis.examination import FilterDiagnosis, Mistake, Note, diagnose
from lie_rigid_body.diagnosis.probing import Probe

__all__ = ["FilterDiagnosis", "Mistake", "Note", "Probe", "diagnose"]
