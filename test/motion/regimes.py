"""Bodies and rates of every regime of torque-free motion, and attitudes to start from."""

from __future__ import annotations

import numpy as np

ATTITUDES = [[0.0, 0.0, 0.0, 1.0], [0.1, -0.7, 0.3, -0.5], [0.5, 0.5, -0.5, 0.5]]

ASYMMETRIC, FLAT, RATIONAL = [0.6, 0.8, 1.0], [1.0, 2.0, 3.0], [3.0, 4.0, 6.0]
# l² = 2H I₂ exactly for RATIONAL when |ω₁| = 2|ω₃|
ON_SEPARATRIX = [[2.0, 3.0, 1.0], [-2.0, 0.3, 1.0], [2.0, -0.3, -1.0], [-2.0, -3.0, -1.0]]
TINY = [1e-2, 1e-5, 1e-8, 1e-12, 1e-16, 1e-30, 1e-100, 1e-300]
CLOSE = [1e-4, 1e-8, 1e-12, 4.5e-16, 2.3e-16]


def near_axes():
    for size in TINY:
        for axis in range(3):
            rate = [size, -2.0 * size, 1.5 * size]
            rate[axis] = -1.3
            yield FLAT if axis == 1 else ASYMMETRIC, rate


def in_principal_planes():
    for size in (0.4, 1e-9, 1e-200):
        for rate in ([0, 1, size], [size, 1, 0], [0, size, 1], [size, 0, 1], [1, size, 0], [1, 0, size]):
            yield ASYMMETRIC, rate


def nearly_symmetric():
    for d in CLOSE:
        for rate in ([0.5, 0.7, 1.1], [0.5, 0.7, 1e-9], [1e-9, 0.7, 0.3], [1.0, 1e-9, 1e-3]):
            yield [1.0, 1.0 + d, 1.7], rate
            yield [0.5, 1.7, 1.7 * (1.0 + d)], rate
            yield [1.0, 1.0 + d, 1.0 + 3.0 * d], rate


def symmetric():
    for rate in ([0.3, 0.5, 1.1], [0.3, 0.5, -1e-12], [1e-12, -0.5, 1.1], [1e-200, 0.5, 1e-200]):
        for inertia in ([1.0, 1.0, 1.8], [2.0, 0.5, 2.0], [0.7, 1.0, 1.0], [1.0, 1.0, 2.0]):
            yield inertia, rate


def across_the_separatrix():
    for rate in ON_SEPARATRIX:
        yield RATIONAL, rate
        for k in (1e-1, 1e-4, 1e-9, 1e-15):
            for side in (1.0 + k, 1.0 - k):
                yield RATIONAL, [rate[0] * side, *rate[1:]]


def beside_the_separatrix():
    """1 − m of about 1e-6 to 1e-30 on each side: with FLAT, l² = 2H I₂ where |ω₁| = √3 |ω₃|."""
    for size in (1e-3, 1e-6, 1e-9, 1e-12, 1e-15):
        for rate in ([size, 1.0, 0.2 * size], [-0.2 * size, -1.0, size]):
            yield FLAT, rate


def flat():
    for inertia in (FLAT, [0.3, 0.7, 1.0], [0.5, 1.0, 0.5]):
        for rate in ([0.3, 0.5, 1.1], [1.1, -0.5, 0.2], [1e-6, 1e-7, 1.0]):
            yield inertia, rate


def steady():
    for rate in ([0.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.3], [2.0, 0.0, 0.0]):
        yield ASYMMETRIC, rate
    yield [2.0, 2.0, 2.0], [0.3, 0.5, 1.1]
    yield [1.0, 1.0, 1.8], [0.3, 0.5, 0.0]
    yield [[2.0, 1.0, 0.0], [1.0, 2.0, 0.0], [0.0, 0.0, 2.0]], [0.5, -0.5, 0.0]


def scaled():
    for scale in (1e12, 1e-12):
        yield [0.6 * scale, 0.8 * scale, 1.0 * scale], [0.3 / scale, -0.5 / scale, 0.9 / scale]
        yield FLAT, [1e-3 * scale, 1.0 * scale, 2e-3 * scale]
    yield [1e-6, 1.0, 1.0 + 5e-7], [200.0, 0.3, 0.1]


def with_products():
    yield [1.0, 0.1, -0.05, 1.4, 0.2, 1.9], [0.4, -1.2, 0.7]
    yield [1.0, 1e-20, 0.0, 1.0, 0.0, 0.5], [1.0, 0.5, 0.2]
    yield [1.0, 1e-100, 0.0, 1.0, 0.0, 0.5], [1.0, 0.5, 0.2]
    yield [1.0, 0.0, 1e-50, 1.0, 0.0, 0.5], [1.0, 0.5, 0.2]
    # circulating about one of two moments that the product of inertia sets apart
    yield [1.0, 1e-20, 0.0, 1.0, 0.0, 0.5], [1.0, 0.5, 1e-11]
    yield [1.0, 1e-100, 0.0, 1.0, 0.0, 0.5], [1.0, 0.5, 1e-51]
    yield [2.0, 1.0, 0.0, 2.0, 0.0, 2.0], [1.0, 0.5, 0.2]
    yield [2.0, 1.0, 0.0, 2.0, 0.0, 2.0], [0.5, -0.5, 0.2]
    yield [2.25, 0.25, 0.25, 2.25, 0.25, 2.25], [0.5, -0.5, 0.2]
    yield [1.75, -0.25, -0.25, 1.75, -0.25, 1.75], [0.5, -0.5, 0.2]
    random = np.random.default_rng(7)
    for moments in ([0.6, 0.8, 1.0], [0.7, 0.7, 1.0], [0.7, 1.0, 1.0], [0.9, 0.9, 0.9]):
        axes = np.linalg.qr(random.normal(size=(3, 3)))[0]
        matrix = axes @ np.diag(moments) @ axes.T
        yield 0.5 * (matrix + matrix.T), random.normal(size=3)


REGIMES = [
    near_axes,
    in_principal_planes,
    nearly_symmetric,
    symmetric,
    across_the_separatrix,
    beside_the_separatrix,
    flat,
    steady,
    scaled,
    with_products,
]
