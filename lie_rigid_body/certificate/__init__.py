"""The certificate of a bag: its samples held against the laws of torque-free motion.

- `survey`, `stamps`, `segments`: a recording cut at its resets, its samples numbered, paired and complete;
- `tolerance`, `propagation`: the limit of each law for the declared motion;
- `laws`, `law_result`: the laws, and how near each came to its limit;
- `readings`, `imu_readings`, `sensor_topics`, `sensors`: what sensors should have read, and their messages beside it;
- `certification`: the verdict on a bag.
"""

from lie_rigid_body.certificate.certification import Certificate, SegmentCertificate, certify
from lie_rigid_body.certificate.law_result import LawResult

__all__ = ["Certificate", "LawResult", "SegmentCertificate", "certify"]
