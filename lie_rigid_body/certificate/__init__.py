"""The conservation certificate: a bag replayed without ROS and held against the laws of torque-free motion."""

from lie_rigid_body.certificate.certificate import Certificate, SegmentCertificate, certify
from lie_rigid_body.certificate.law import Law

__all__ = ["Certificate", "Law", "SegmentCertificate", "certify"]
