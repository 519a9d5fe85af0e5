"""The services that need no package but std_srvs: reset, pause, resume, step."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from std_srvs.srv import Trigger

from lie_rigid_body.ros.timing.live_run import LiveRun
from lie_rigid_body.scenario import Scenario

Handler = Callable[[Trigger.Request, Trigger.Response], Trigger.Response]


class Services:
    """The private services of a node, each a std_srvs/Trigger.

    Parameters
    ----------
    run : LiveRun
    scenario : callable
        Returns the scenario of the present parameters, or raises what is wrong with them.
    """

    def __init__(self, run: LiveRun, scenario: Callable[[], Scenario]) -> None:
        self._run = run
        self._scenario = scenario

    def offer(self, node: Node) -> None:
        """Create the services."""
        # a step waits for its sample, and must not keep the other services waiting
        concurrent = ReentrantCallbackGroup()
        for action in (self.reset, self.pause, self.resume):
            node.create_service(Trigger, f"~/{action.__name__}", _handler(action))
        node.create_service(Trigger, "~/step", _handler(self.step), callback_group=concurrent)

    def reset(self) -> str:
        """Begin a new segment, and say at which stamp."""
        segment = self._run.ask(self._run.reset, self._scenario())
        return f"the sample stamped {segment.start_ns} ns begins the motion anew"

    def pause(self) -> str:
        """Stop simulated time, and say at which stamp."""
        return f"time stands still at {self._run.ask(self._run.pause)} ns"

    def resume(self) -> str:
        """Let simulated time pass again."""
        self._run.ask(self._run.resume)
        return "time goes on"

    def step(self) -> str:
        """While paused, send the next sample, and say its stamp."""
        self._run.ask(self._run.step, 1).wait()
        stamp_ns, _ = self._run.ask(lambda: self._run.latest)
        return f"sent the sample stamped {stamp_ns} ns"


def _handler(action: Callable[[], str]) -> Handler:
    """A service handler that answers with the text an action returns, or with its error."""

    def handle(request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        try:
            response.message = action()
        except Exception as error:
            response.success, response.message = False, str(error) or type(error).__name__
        else:
            response.success = True
        return response

    return handle
