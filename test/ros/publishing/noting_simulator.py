"""The node, which notes in a file, at once, what its recorder does: started by `test_kills.py` and then killed.

Each line is a word and numbers: ``tick`` and the steady time, ns, when a turn of the recorder is over; ``flush`` and
the stamp, ns, of the last sample that was handed over before; ``written`` when the disk's thread is done with a flush,
the first one first. A line is one write to a file, which outlives the process.
"""

from __future__ import annotations

import os
import sys

from lie_rigid_body.__main__ import main
from lie_rigid_body.messages.batch import Batch
from lie_rigid_body.recording.bag_writer import BagWriter
from lie_rigid_body.ros.publishing.recorder import Recorder
from lie_rigid_body.ros.timing.sink import Punctuality

notes = os.open(sys.argv.pop(1), os.O_CREAT | os.O_APPEND | os.O_WRONLY)
write, tick, flush, sync = Recorder.write, Recorder.tick, BagWriter.flush, BagWriter._sync
last_ns = 0


def note(*words: object) -> None:
    os.write(notes, f"{' '.join(map(str, words))}\n".encode())


def noted_write(self: Recorder, batch: Batch) -> None:
    global last_ns
    write(self, batch)
    if len(batch.samples.stamps_ns):
        last_ns = int(batch.samples.stamps_ns[-1])


def noted_tick(self: Recorder, steady_ns: int, punctuality: Punctuality) -> int:
    wait_ns = tick(self, steady_ns, punctuality)
    note("tick", steady_ns)
    return wait_ns


def noted_flush(self: BagWriter) -> None:
    note("flush", last_ns)
    flush(self)


def noted_sync(self: BagWriter, number: int) -> None:
    sync(self, number)
    note("written")


Recorder.write, Recorder.tick = noted_write, noted_tick  # type: ignore[method-assign]
BagWriter.flush, BagWriter._sync = noted_flush, noted_sync  # type: ignore[method-assign]
sys.argv.insert(1, "sim")
sys.exit(main())
