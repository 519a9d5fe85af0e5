"""The state rid of what round-off has done to its invariants, in double-double.

Between two restorations they are off by some 1e-17. What cannot be restored is where on its orbit the momentum is,
and the angle of the body about the spatial momentum: round-off makes these two, and nothing else, a random walk.
"""

from __future__ import annotations

from typing import Any, Final

from lie_rigid_body.compilation import kernel
from lie_rigid_body.motion.moser_veselov.double_double import Pair, add, multiply, subtract
from lie_rigid_body.motion.moser_veselov.step import Four, Three, increased

STEADY: Final = 1e-16
"""Square of the angle between momentum and rate below which the length of the momentum determines the energy."""


@kernel
def restored_momentum(n: Three, constants: Any) -> Three:
    """The nearest momentum of unit length and of the energy of the start."""
    e1, e2, e3 = constants[2], constants[4], constants[6]
    a, b, c = multiply(n[0], n[0]), multiply(n[1], n[1]), multiply(n[2], n[2])
    length = subtract(add(a, add(b, c)), (1.0, 0.0))[0]
    energy = add(multiply((e1, constants[3]), a), add(multiply((e2, constants[5]), b), multiply((e3, constants[7]), c)))
    excess = subtract(energy, (constants[16], constants[17]))[0]
    # the energy, and half its gradient, less what the length accounts for
    mean = energy[0]
    across = excess - mean * length
    g1, g2, g3 = n[0][0] * (e1 - mean), n[1][0] * (e2 - mean), n[2][0] * (e3 - mean)
    square = g1 * g1 + g2 * g2 + g3 * g3
    size = e1 * e1 * a[0] + e2 * e2 * b[0] + e3 * e3 * c[0]
    shift = 0.5 * across / square if square > STEADY * size else 0.0
    return (
        increased(n[0], -(0.5 * length * n[0][0] + shift * g1), 0.0),
        increased(n[1], -(0.5 * length * n[1][0] + shift * g2), 0.0),
        increased(n[2], -(0.5 * length * n[2][0] + shift * g3), 0.0),
    )


@kernel
def restored_attitude(q: Four, n: Three, world: Three) -> Four:
    """The nearest unit quaternion that turns the momentum n into the spatial momentum of the start."""
    x, y, z, w = unit(q)
    t1, t2, t3 = cross((x, y, z), n)
    u1, u2, u3 = add(t1, multiply(w, n[0])), add(t2, multiply(w, n[1])), add(t3, multiply(w, n[2]))
    # A n = w(w n + v × n) + v(v·n) + v × (w n + v × n)
    c1, c2, c3 = cross((x, y, z), (u1, u2, u3))
    dot = add(multiply(x, n[0]), add(multiply(y, n[1]), multiply(z, n[2])))
    r1 = subtract(add(add(multiply(w, u1), multiply(x, dot)), c1), world[0])[0]
    r2 = subtract(add(add(multiply(w, u2), multiply(y, dot)), c2), world[1])[0]
    r3 = subtract(add(add(multiply(w, u3), multiply(z, dot)), c3), world[2])[0]
    l1, l2, l3 = world[0][0], world[1][0], world[2][0]
    # half the rotation vector, in the world, that takes A n back
    a, b, c = 0.5 * (r2 * l3 - r3 * l2), 0.5 * (r3 * l1 - r1 * l3), 0.5 * (r1 * l2 - r2 * l1)
    return (
        increased(x, w[0] * a + b * z[0] - c * y[0], 0.0),
        increased(y, w[0] * b + c * x[0] - a * z[0], 0.0),
        increased(z, w[0] * c + a * y[0] - b * x[0], 0.0),
        increased(w, -(a * x[0] + b * y[0] + c * z[0]), 0.0),
    )


@kernel
def unit(q: Four) -> Four:
    """A quaternion brought to unit norm by one Newton step."""
    x, y, z, w = q
    square = add(add(multiply(x, x), multiply(y, y)), add(multiply(z, z), multiply(w, w)))
    less = -0.5 * subtract(square, (1.0, 0.0))[0]
    return (
        increased(x, less * x[0], 0.0),
        increased(y, less * y[0], 0.0),
        increased(z, less * z[0], 0.0),
        increased(w, less * w[0], 0.0),
    )


@kernel
def cross(a: Three, b: Three) -> Three:
    """The product a × b."""
    return minor(a[1], b[2], a[2], b[1]), minor(a[2], b[0], a[0], b[2]), minor(a[0], b[1], a[1], b[0])


@kernel
def minor(a: Pair, b: Pair, c: Pair, d: Pair) -> Pair:
    """The difference ab − cd."""
    return subtract(multiply(a, b), multiply(c, d))
