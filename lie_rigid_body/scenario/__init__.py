"""A scenario: the parameters of one run.

- `parameter_table`: every parameter, its type, default and limits;
- `parameter_file`: reading them from files and assignments;
- `definition`: the scenario made of them, frozen and validated as a whole;
- `arcs`: what is conserved from kick to kick;
- `facts`: what of it is no free rotation, in words;
- `kick_numbers`: kicks at random.
"""

from lie_rigid_body.scenario.definition import Scenario
from lie_rigid_body.scenario.kick_numbers import random_kicks

__all__ = ["Scenario", "random_kicks"]
