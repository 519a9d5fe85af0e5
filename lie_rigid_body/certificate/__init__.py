"""The certificate of a bag: its samples held against the laws of torque-free motion.

- `survey`, `stamps`: a recording cut at its resets, its samples numbered, paired and complete;
- `limits`: the limit L of each kind of motion;
- `laws`, `law_result`: samples beside the exact motion, and how near each law came to its limit;
- `readings`: sensors replayed; `sensor_topics`, `sensors`: their messages beside the replay;
- `told_faults`: the messages about faults, beside those that the scenarios make;
- `whole_bag`: the laws of a bag as a whole, and what no law speaks of;
- `certification`: the verdict on a bag.
"""

from lie_rigid_body.certificate.certification import Certificate, SegmentCertificate, certify
from lie_rigid_body.certificate.law_result import LawResult

__all__ = ["Certificate", "LawResult", "SegmentCertificate", "certify"]
