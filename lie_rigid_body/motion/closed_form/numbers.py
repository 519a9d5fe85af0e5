"""Small sets of numbers: floats of one motion, or arrays with an element for each of many.

Every formula of a motion is elementwise, so that a motion whose numbers are arrays is that many motions, and each of
them has the bits that it has alone.
"""

from __future__ import annotations

from lie_rigid_body.motion.closed_form.double_double import Number

Triple = tuple[Number, Number, Number]
Quadruple = tuple[Number, Number, Number, Number]
