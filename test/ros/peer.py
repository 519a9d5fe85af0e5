"""Another node, in the process of the test."""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from typing import Any

import rclpy
from rcl_interfaces.msg import Parameter as ParameterMessage
from rcl_interfaces.srv import SetParametersAtomically
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.parameter_client import AsyncParameterClient
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from simulator_process import DEADLINE
from std_srvs.srv import Trigger

NODE = "/lie_rigid_body"
LATCHED = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Peer:
    """Another node, and what it asks of the simulator. Its context is its own: tests may initialise rclpy as well."""

    def __init__(self, name: str, domain: int | None = None) -> None:
        self._context = Context()
        rclpy.init(args=[], context=self._context, domain_id=domain)
        self.node = rclpy.create_node(name, context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._clients: dict[str, Any] = {}
        self._parameters: AsyncParameterClient | None = None

    def __enter__(self) -> Peer:
        return self

    def __exit__(self, *failure: object) -> None:
        self._executor.shutdown()
        self.node.destroy_node()
        rclpy.shutdown(context=self._context)

    def answer(self, kind: type, service: str, request: object) -> Any:
        return self.wait_for(self.client(kind, service).call_async(request))

    def client(self, kind: type, service: str) -> Any:
        client = self._clients.get(service) or self.node.create_client(kind, service)
        self._clients[service] = client
        assert client.wait_for_service(DEADLINE), service
        return client

    def wait_for(self, future: Any) -> Any:
        self._executor.spin_until_future_complete(future, DEADLINE)
        assert future.done()
        return future.result()

    def listen(self, kind: type, topic: str, qos: QoSProfile | int = 1000) -> list[Any]:
        messages: list[Any] = []
        self.node.create_subscription(kind, topic, messages.append, qos)
        return messages

    def publishers(self, topic: str) -> list[Any]:
        """What publishes on a topic, once anything does: a node is known before its topics are."""
        self.spin_until(lambda: self.node.count_publishers(topic), f"a publisher of {topic}")
        return list(self.node.get_publishers_info_by_topic(topic))

    def listen_no_more(self) -> None:
        """Old subscriptions, which are always ready, would keep new ones waiting."""
        for subscription in list(self.node.subscriptions):
            self.node.destroy_subscription(subscription)

    def spin_until(self, condition: Callable[[], object], what: str, deadline: float = DEADLINE) -> None:
        end = time.monotonic() + deadline
        while not condition():
            assert time.monotonic() < end, f"waited {deadline:g} s for {what}"
            self._executor.spin_once(timeout_sec=0.1)

    def call(self, name: str) -> Trigger.Response:
        return self.answer(Trigger, f"{NODE}/{name}", Trigger.Request())

    def stamp(self, name: str) -> int:
        """The stamp, ns, in the answer of a service that succeeds."""
        answer = self.call(name)
        assert answer.success, answer.message
        [found] = re.findall(r"\d+", answer.message)
        return int(found)

    def set_together(self, **values: object) -> Any:
        parameters = [Parameter(name, value=value).to_parameter_msg() for name, value in values.items()]
        request = SetParametersAtomically.Request(parameters=parameters)
        return self.answer(SetParametersAtomically, f"{NODE}/set_parameters_atomically", request).result

    def parameters(self) -> AsyncParameterClient:
        self._parameters = self._parameters or AsyncParameterClient(self.node, NODE)
        assert self._parameters.wait_for_services(DEADLINE)
        return self._parameters

    def values(self, *names: str) -> list[Any]:
        found = self.wait_for(self.parameters().get_parameters(list(names))).values
        messages = [ParameterMessage(name=name, value=value) for name, value in zip(names, found, strict=True)]
        return [Parameter.from_parameter_msg(message).value for message in messages]
