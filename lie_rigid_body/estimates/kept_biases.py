"""The biases of a gyro on a topic, estimated or true, as they come, in memory that does not grow."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lie_rigid_body.arrays import Array, Integers
from lie_rigid_body.estimates.kept_attitudes import LENIENCE_NS
from lie_rigid_body.evaluation.score import BiasEstimate
from lie_rigid_body.recording.topic_messages import vectors_of
from lie_rigid_body.runs.readings import linear


class KeptBiases:
    """Finite biases, evenly thinned so that memory does not grow.

    Parameters
    ----------
    most : int
        Largest number that are kept.

    Attributes
    ----------
    topic : str
        Empty until a message came.
    stamps_ns : ndarray of int64, shape (N,)
        As they came: perhaps not in order.
    values : ndarray, shape (N, 3)
        Biases, rad/s.
    """

    def __init__(self, most: int) -> None:
        self._most, self._count, self._left_out, self._stride = most, 0, 0, 1
        self.topic, self.stamps_ns, self.values = "", np.empty(0, dtype=np.int64), np.empty((0, 3))

    def hear(self, topic: str, message_type: str, payloads: Sequence[bytes]) -> None:
        """Take messages.

        Raises
        ------
        BagError
            If one cannot be read: then none is taken.
        """
        self.take(topic, *vectors_of(message_type, payloads))

    def take(self, topic: str, stamps_ns: Integers, values: Array) -> None:
        """Take biases, rad/s, shape (N, 3), with their stamps."""
        self.topic = topic
        finite = np.flatnonzero(np.isfinite(values).all(axis=1))
        kept = finite[-self._count % self._stride :: self._stride]
        self._count += len(finite)
        self._left_out += len(values) - len(finite)
        self.stamps_ns = np.concatenate([self.stamps_ns, stamps_ns[kept]])
        self.values = np.concatenate([self.values, values[kept]])
        while len(self.values) > self._most:
            self.stamps_ns, self.values, self._stride = self.stamps_ns[::2], self.values[::2], 2 * self._stride

    @property
    def notes(self) -> list[str]:
        """What the reader of a score should know of them, one sentence each."""
        count = self._left_out
        told = f"{count} of {count + self._count} biases on {self.topic} are not finite, and are left out"
        return [f"{told}; find out why they were given."] * (count > 0)

    def between(self, first_ns: int, last_ns: int) -> tuple[Integers, Array]:
        """Stamps and biases from one stamp to another, ns, in their order."""
        order = np.argsort(self.stamps_ns, kind="stable")
        stamps_ns = self.stamps_ns[order]
        rows = slice(*np.searchsorted(stamps_ns, [first_ns, last_ns + 1]))
        return stamps_ns[rows], self.values[order][rows]

    def beside(self, truth: KeptBiases, first_ns: int, last_ns: int) -> BiasEstimate | None:
        """Biases from one stamp to another, ns, where the true ones are known; None where there are none.

        The true ones are linear between those that were heard, and constant for a second before and after them.
        """
        known_ns, known = truth.between(first_ns - LENIENCE_NS, last_ns + LENIENCE_NS)
        if not len(known):
            return None
        span = max(first_ns, int(known_ns[0]) - LENIENCE_NS), min(last_ns, int(known_ns[-1]) + LENIENCE_NS)
        stamps_ns, values = self.between(*span)
        if not len(values):
            return None
        return BiasEstimate(stamps_ns, values, linear(stamps_ns, known_ns, known))
