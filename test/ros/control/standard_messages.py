"""Requests and responses with exactly the fields of simulation_interfaces 1.5, which PyPI does not have.

As from rclpy, each is filled with its defaults: a result reads "unsupported" (0) until it is set.
"""

from __future__ import annotations

from types import SimpleNamespace

from geometry_msgs.msg import Accel, Pose, Twist
from std_msgs.msg import Header


class Message(SimpleNamespace):
    """Refuses fields that it was not made with, as a message does."""

    def __setattr__(self, name: str, value: object) -> None:
        if name not in self.__dict__:
            raise AttributeError(name)
        super().__setattr__(name, value)


def result() -> Message:
    return Message(result=0, error_message="")


def entity_state() -> Message:
    return Message(header=Header(), pose=Pose(), twist=Twist(), acceleration=Accel())


def category(number: int = 0) -> Message:
    return Message(category=number)


def entity_filters(pattern: str = "", categories: tuple[int, ...] = ()) -> Message:
    return Message(
        filter=pattern,
        categories=[category(number) for number in categories],
        tags=Message(tags=[], filter_mode=0),
        bounds=Message(type=0, points=[]),
    )


RESPONSES = {
    "get_simulator_features": lambda: Message(features=Message(features=[], spawn_formats=[], custom_info="")),
    "reset_simulation": lambda: Message(result=result()),
    "get_simulation_state": lambda: Message(state=Message(state=0), result=result()),
    "set_simulation_state": lambda: Message(result=result()),
    "step_simulation": lambda: Message(result=result()),
    "simulate_steps": lambda: Message(result=result()),
    "get_entities": lambda: Message(result=result(), entities=[]),
    "get_entities_states": lambda: Message(result=result(), entities=[], states=[]),
    "get_entity_info": lambda: Message(result=result(), info=Message(category=category(), description="", tags=[])),
    "get_entity_state": lambda: Message(result=result(), state=entity_state()),
    "set_entity_state": lambda: Message(result=result()),
}


def feedback() -> Message:
    return Message(completed_steps=0, remaining_steps=0)
