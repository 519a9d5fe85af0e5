"""The messages of the truth: poses, twists and texts."""

from __future__ import annotations

from lie_rigid_body.messages.layout import ENCAPSULATION, POSE_NUMBERS, TWIST_NUMBERS, Layout, text
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Samples


class MessageEncoder:
    """Samples as the bytes that go to a publisher or into a bag.

    Parameters
    ----------
    scenario : Scenario
        Gives the frame names and whether twists are stamped.
    """

    def __init__(self, scenario: Scenario) -> None:
        twist_frame = scenario.body_frame if scenario.stamped_twist else None
        # position and linear velocity stay zero; the rotation's numbers follow them
        self._pose = Layout(scenario.world_frame, [0.0] * POSE_NUMBERS, [(3, 4)])
        self._twist = Layout(twist_frame, [0.0] * TWIST_NUMBERS, [(3, 3)])

    def poses(self, samples: Samples) -> list[bytes]:
        """One geometry_msgs/PoseStamped a sample, position 0."""
        return self._pose.encode(samples.stamps_ns, samples.states.attitude_xyzw)

    def twists(self, samples: Samples) -> list[bytes]:
        """One geometry_msgs/TwistStamped or Twist a sample, linear velocity 0."""
        return self._twist.encode(samples.stamps_ns, samples.states.body_rate)


def encode_string(value: str) -> bytes:
    """A std_msgs/String."""
    return ENCAPSULATION + text(value)
