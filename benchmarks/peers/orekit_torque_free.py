"""Orekit: its attitude provider `TorqueFree`, in Java, by orekit_jpype.

It evaluates Euler's angles by Jacobi's functions, and the third of them by a quadrature over one period with tolerance
1e-13, which it keeps for all times. Its constructor, and a few calls from Python for each instant, are charged.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Final

import numpy as np
import orekit_jpype
from numpy.typing import NDArray

from peers.contender import Contender
from peers.task import ATTITUDE, INERTIA, NS, RATE, Task

orekit_jpype.initVM()

# Java's packages can be imported once its machine runs.
from org.hipparchus.geometry.euclidean.threed import Rotation, Vector3D  # noqa: E402
from org.orekit.attitudes import Attitude, Inertia, InertiaAxis, TorqueFree  # noqa: E402
from org.orekit.frames import FramesFactory  # noqa: E402
from org.orekit.time import AbsoluteDate  # noqa: E402

FRAME: Final = FramesFactory.getGCRF()
START: Final = AbsoluteDate.ARBITRARY_EPOCH
AXES: Final = (Vector3D.PLUS_I, Vector3D.PLUS_J, Vector3D.PLUS_K)


def contenders(task: Task) -> Iterator[Contender]:
    """One, exact but for its quadrature."""
    yield Contender("Orekit, TorqueFree", "exact", 0.0, lambda: _attitudes((task.times_ns / NS).tolist()))


def _attitudes(times: list[float]) -> NDArray[np.float64]:
    model = _model()
    found = np.empty((len(times), 4))
    for row, t in zip(found, times, strict=True):
        # From the world to the body, with the sign of the vector that a rotation of vectors the other way has.
        rotation = model.getAttitude(None, START.shiftedBy(t), FRAME).getRotation()
        row[:] = rotation.getQ1(), rotation.getQ2(), rotation.getQ3(), rotation.getQ0()
    return found


def _model() -> Any:
    x, y, z, w = ATTITUDE.tolist()
    start = Attitude(START, FRAME, Rotation(w, x, y, z, False), Vector3D(*RATE.tolist()), Vector3D.ZERO)
    axes = (InertiaAxis(moment, axis) for moment, axis in zip(INERTIA.tolist(), AXES, strict=True))
    return TorqueFree(start, Inertia(*axes))
