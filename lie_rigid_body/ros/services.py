"""The services that are always there: reset, pause, resume, step."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from std_srvs.srv import Trigger

from lie_rigid_body.ros.run_control import RunControl
from lie_rigid_body.scenario import Scenario

Handler = Callable[[Trigger.Request, Trigger.Response], Trigger.Response]


class Services:
    """The private services of a node, each a std_srvs/Trigger.

    Parameters
    ----------
    control : RunControl
    scenario : callable
        The scenario that the parameters now hold; may raise whatever goes wrong.
    """

    def __init__(self, control: RunControl, scenario: Callable[[], Scenario]) -> None:
        self._control = control
        self._scenario = scenario

    def offer(self, node: Node) -> None:
        """Create the services."""
        # a step waits for its samples: others are answered meanwhile
        apart = ReentrantCallbackGroup()
        node.create_service(Trigger, "~/reset", _answered(self.reset))
        node.create_service(Trigger, "~/pause", _answered(self.pause))
        node.create_service(Trigger, "~/resume", _answered(self.resume))
        node.create_service(Trigger, "~/step", _answered(self.step), callback_group=apart)

    def reset(self) -> str:
        """Begin the motion anew."""
        segment = self._control.reset(self._scenario())
        return f"the sample stamped {segment.start_ns} ns begins the motion anew"

    def pause(self) -> str:
        """Let time stand still."""
        return f"time stands still at {self._control.pause()} ns"

    def resume(self) -> str:
        """Let time go on."""
        self._control.resume()
        return "time goes on"

    def step(self) -> str:
        """Send the next sample while time stands still."""
        self._control.step(1).wait()
        stamp_ns, _ = self._control.latest()
        return f"sent the sample stamped {stamp_ns} ns"


def _answered(action: Callable[[], str]) -> Handler:
    """A handler that tells what an action says, or why it failed."""

    def handle(request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        try:
            response.message = action()
        except Exception as error:
            response.success, response.message = False, str(error) or type(error).__name__
        else:
            response.success = True
        return response

    return handle
