"""A scenario: the parameters of one run, checked and frozen, and the files that hold them."""

from lie_rigid_body.scenario.definition import Scenario

__all__ = ["Scenario"]
