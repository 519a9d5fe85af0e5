"""What certificates say: a sentence for each thing that may be wrong with a bag, or that is not certified of it."""
# mypy: ignore-errors

from __future__ import annotations

from pathlib import Path

import numpy as np
from sensor_bags import AT, BIAS, FORCE, IMU, MAG, MOTIONS, NOISY, certificate, recorded, write
from tampering import at, declared, flipped, on, with_numbers
from test_certified_clocks import moved

from lie_rigid_body.foundation.errors import BagError

LATER_VERSION = declared(software="lie_rigid_body 0.0.9")
OFF = on(IMU, at(AT, lambda m: with_numbers(m, 24, lambda x: np.append(1.5 * x[:3], x[3:]))))


def missing(topic, count=1):
    return on(topic, lambda ms: [*ms[:AT], *ms[AT + count :]])


def twice(topic):
    return on(topic, lambda ms: [*ms[: AT + 1], *ms[AT:]])


def exchanged(topic):
    return on(topic, lambda ms: [*ms[:AT], ms[AT + 1], ms[AT], *ms[AT + 2 :]])


def renamed(topic):
    return on(topic, at(AT, lambda m: m._replace(data=m.data.replace(b"imu_link", b"imu_lunk"))))


def told(*changes):
    """What the certificate of a bag that was changed says beyond that of the bag."""
    path = write(Path("bag.mcap"), ({**MOTIONS["dmv20"], **FORCE, **NOISY}, 0.995))

    def said(*changes):
        def change(messages):
            for each in changes:
                messages = each(messages)
            return messages

        found = certificate(path, Path(), change)
        notes = [note for segment in found.segments for note in segment.notes]
        return [*found.messages, *found.not_certified, *notes]

    usual = said()
    return "\n".join(text for text in said(*changes) if text not in usual)


REFUSED = {BagError: [lambda: told(declared(first_sample=5))]}
SAID = [
    lambda: told(OFF),
    lambda: told(on("/pose", lambda ms: [m._replace(log_time=m.log_time + 1000) for m in ms])),
    lambda: told(on("/pose", at(AT, flipped))),
    lambda: told(declared(inertia=[1.0, 2.0, 30.0])),
    lambda: told(moved(1)),
    lambda: told(recorded(0.1)),
    lambda: told(missing("/pose", 5), recorded(0.1)),
    lambda: told(renamed(MAG)),
    lambda: told(missing("/pose")),
    lambda: told(twice("/pose")),
    lambda: told(exchanged("/twist")),
    lambda: told(missing(MAG)),
    lambda: told(missing(MAG, 4)),
    lambda: told(twice(BIAS)),
    lambda: told(exchanged(BIAS)),
    lambda: told(declared(magnetometer_rate=0.0)),
    lambda: told(LATER_VERSION, OFF),
    lambda: told(lambda ms: [m for m in ms if m.topic != BIAS], recorded(0.1)),
]
