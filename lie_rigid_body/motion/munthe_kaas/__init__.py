"""The Runge–Kutta–Munthe-Kaas steppers ``rkmk1``, ``rkmk2`` and ``rkmk4``: Runge–Kutta steps in the moving chart.

Modules:

- `tableau`: the coefficients of the methods;
- `loop`: the steps in plain numbers, run compiled or not;
- `integrator`: one body's motion, and how long its steps may be.
"""

from lie_rigid_body.motion.munthe_kaas.integrator import MuntheKaasIntegrator
from lie_rigid_body.motion.munthe_kaas.tableau import CLASSICAL, EULER, MIDPOINT, ChainTableau

__all__ = ["CLASSICAL", "EULER", "MIDPOINT", "ChainTableau", "MuntheKaasIntegrator"]
