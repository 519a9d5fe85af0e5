"""Wording of what is refused of runs, estimates and filters, and said of scores: other tests give its name."""

from __future__ import annotations

from lie_rigid_body.foundation.errors import BagError, InputError, LieRigidBodyError
from said import refusals

PHRASES = {
    "gyro at its limit": "at the limit of its range in 100 % of the readings: the body turns faster",
    "of the sensors": "a constant turn is about what these sensors leave to a right filter, ",
    "nearer than noise": "nearer than noise allows: it has seen the truth, or the noise is not as declared",
    "no best filter": "best filter  not known: no sensor tells a turn about the vertical",
    "drawn bound": "best by noise",
}
"""Parts of what is said of a score."""
refused = refusals(
    {
        InputError: {
            # arguments of simulate
            "scenario": "^scenario '{name}' is unknown",
            "duration": "duration {value} is not a time",
            "parameter": "did you mean {like}",
            "inertia": "triangle",
            "no order": "{name}: .* is not a list",
            "seed beside seeds": "beside seeds",
            "seed": "sensor_seed: {value} is outside",
            "no name": "scenario {value} is no name",
            "path as name": r"'{name}' is no name of one, but a path: give it as pathlib.Path\(",
            "seeds": "seeds {value} are no numbers in a row",
            "no seeds": "seeds are none",
            "bytes": "memory_limit {value} is not a number of bytes",
            "declared readings": "the scenario declares {count} readings",
            "noise": "^vector: a noise of {value} of what is read is beyond",
            "record_path": r"call to_bag\('{path}'\) of the run",
            "memory": "memory_limit .* is too little for .* which take .* give a larger memory_limit",
            # a run and its bag
            "topics": "^topics",
            "untold": "{count} of {of} .* {topic}",
            "readings without a sensor": "{count} readings of a sensor, {sensor}, that its scenario has not",
            "topic twice": "one name",
            "topic": "'?{topic}'? is no name",
            "no topics": "^{name}: .* has no topics: give it by its topic",
            "score": "^scores: .*: give the Score of an estimate by the topic of that estimate",
            # estimates
            "rows": "{rows} rows goes neither with {readings} readings of the IMU nor with {samples} samples",
            "not finite": "{name}: {count} of {of} rows are not finite",
            "all not finite": "{count} of {count} estimates are not finite",
            "zero": "{count} of {of} quaternions are zero",
            "integers": "{name}: stamps of type {kind}: give integer nanoseconds",
            "no bias": "does not tell the bias",
            "stamps": "all of its {count} stamps are {stamp}",
            "transposed": "transpose",
            "angles": "Euler",
            "matrices": "from_matrix",
            "seconds": "round",
            "number of stamps": "stamps",
            "covariance": "covariance",
            "axes": "axes",
            "gyro_bias": "gyro_bias",
            "another clock": "none of its {count} stamps is within the truth, from 0 s to .* s: they begin 1",
            "no run": "give the run",
            "not a truth": "has no stamps: give the run, an ExactTruth or a SampledTruth",
            # live
            "frames": "{frames}, none of which is world to base_link",
            "orientation": "has no orientation",
            "no truth": "neither a scenario nor a pose came",
            "no scenario": "not the JSON",
            "live duration": "is not a time from 1e-9 to 1e10 seconds: give for example 60",
            # programs
            "no attitude": "prints no attitude: print ",
            "prints": "prints more than {most} bytes",
            "not started": "cannot be started: it is {fault}: give the path",
            "hangs": "within {seconds} s",
        },
        LieRigidBodyError: {"two bodies": "is of the frames world, b"},
        BagError: {
            "exists": "exists and is kept",
            "bodies": 'holds 2 bodies, /a, /b: say which, as by topics={{"pose": "/a/pose"}}$',
            "no topic": 'topics={{"pose": "{topic}"}}: there is no topic {topic}: did you mean',
            "scenario topic": r"no topic \.\.\./scenario \(String: body, motion, frames\)",
        },
    }
)
