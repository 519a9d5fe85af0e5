"""Another node, in the process of the test."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import rclpy
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.srv import SetParametersAtomically
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from simulator_process import DEADLINE, eventually
from std_srvs.srv import Trigger

LATCHED = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Peer:
    """Another node, and what it asks of the simulator."""

    def __init__(self, name: str) -> None:
        self.node = rclpy.create_node(name)
        self._clients: dict[str, Any] = {}

    def answer(self, kind: type, service: str, request: object) -> Any:
        return self.wait_for(self.client(kind, service).call_async(request))

    def client(self, kind: type, service: str) -> Any:
        client = self._clients.get(service) or self.node.create_client(kind, service)
        self._clients[service] = client
        assert client.wait_for_service(DEADLINE), service
        return client

    def wait_for(self, future: Any) -> Any:
        rclpy.spin_until_future_complete(self.node, future, timeout_sec=DEADLINE)
        assert future.done()
        return future.result()

    def listen(self, kind: type, topic: str, qos: QoSProfile | int = 1000) -> list[Any]:
        messages: list[Any] = []
        self.node.create_subscription(kind, topic, messages.append, qos)
        return messages

    def listen_no_more(self) -> None:
        """Old subscriptions, which are always ready, would keep new ones waiting."""
        for subscription in list(self.node.subscriptions):
            self.node.destroy_subscription(subscription)

    def spin_until(self, condition: Callable[[], object], what: str) -> None:
        def spun() -> bool:
            rclpy.spin_once(self.node, timeout_sec=0.1)
            return bool(condition())

        eventually(spun, what)

    def reset(self) -> Trigger.Response:
        return self.answer(Trigger, "/lie_rigid_body/reset", Trigger.Request())

    def set_together(self, **values: object) -> Any:
        parameters = [Parameter(name, value=value).to_parameter_msg() for name, value in values.items()]
        request = SetParametersAtomically.Request(parameters=parameters)
        return self.answer(SetParametersAtomically, "/lie_rigid_body/set_parameters_atomically", request).result

    def values(self, client: AsyncParameterClient, *names: str) -> list[Any]:
        found = self.wait_for(client.get_parameters(list(names))).values
        messages = [ParameterMessage(name=name, value=value) for name, value in zip(names, found, strict=True)]
        return [Parameter.from_parameter_msg(message).value for message in messages]
