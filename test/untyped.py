"""Public functions without their types: tests read what may be None, and give what is refused."""

from __future__ import annotations

from typing import Any

import lie_rigid_body

evaluate: Any = lie_rigid_body.evaluate
simulate: Any = lie_rigid_body.simulate
