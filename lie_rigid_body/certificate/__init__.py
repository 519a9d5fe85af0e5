"""The certificate of a bag: its samples held against the laws of torque-free motion.

- `survey`, `stamps`, `segments`: a recording cut at its resets, its samples numbered, paired and complete;
- `tolerance`, `propagation`: the limit of each law for the declared motion;
- `laws`, `law_result`: the laws, and how near each came to its limit;
- `readings`, `sensor_topics`, `sensors`: what sensors should have read, replayed, and their messages beside it;
- `told_faults`: the messages about faults, beside those that the scenarios make;
- `certification`: the verdict on a bag.
"""

from lie_rigid_body.certificate.certification import Certificate, SegmentCertificate, certify
from lie_rigid_body.certificate.law_result import LawResult

__all__ = ["Certificate", "LawResult", "SegmentCertificate", "certify"]
