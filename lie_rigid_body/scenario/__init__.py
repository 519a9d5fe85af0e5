"""A scenario: the parameters of one run.

- `parameter_table`: every parameter, its type, default and limits;
- `parameter_file`: reading them from files and assignments;
- `definition`: the scenario made of them, frozen and validated as a whole.
"""

from lie_rigid_body.scenario.definition import Scenario

__all__ = ["Scenario"]
