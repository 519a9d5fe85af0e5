"""The certificate of a bag: its samples held against the laws of torque-free motion.

- `survey`, `stamps`: a recording cut at its resets, its samples numbered, paired and complete;
- `tolerance`: the limit of each law for the declared motion;
- `laws`, `law_result`: the laws, and how near each came to its limit;
- `readings`: replay; `sensor_topics`, `sensors`: pair the messages of sensors with it, compare, and tell;
- `told_faults`: the messages about faults, beside those that the scenarios make;
- `whole_bag`: the laws of a bag as a whole, and what no law speaks of;
- `certification`: the verdict on a bag.
"""

from lie_rigid_body.certificate.certification import Certificate, SegmentCertificate, certify
from lie_rigid_body.certificate.law_result import LawResult

__all__ = ["Certificate", "LawResult", "SegmentCertificate", "certify"]
