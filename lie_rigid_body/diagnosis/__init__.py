"""Diagnosis of an attitude filter that can be run again: its mistakes by repairs, its abilities by probes.

A filter is run on readings of perfect sensors. Where it errs, its readings and its estimate are repaired from outside,
and the repair that makes the error vanish names the mistake.

- `course`: the motions, and what sensors read of them;
- `repairs`: changes of the readings; `outputs`: those of the estimate; `answers`: what a filter answers with them;
- `filter_runs`: runs of the filter with repairs; `search`: which repairs are tried; `trials`: the rule that chooses;
- `situations`: where the filter is right, if no repair explains its error;
- `probes`: what the filter can do, with one thing at a time in its way; `probing`: how a probe is run;
- `examination`: all of it in order; `filter_diagnosis`: what is said.
"""

from lie_rigid_body.diagnosis.examination import diagnose
from lie_rigid_body.diagnosis.filter_diagnosis import FilterDiagnosis, Mistake, Note
from lie_rigid_body.diagnosis.probing import Probe

__all__ = ["FilterDiagnosis", "Mistake", "Note", "Probe", "diagnose"]
