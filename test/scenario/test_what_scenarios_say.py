"""What scenarios and their files say where they are refused: the one table of these words."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from lie_rigid_body.foundation.errors import InputError
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.scenario.parameter_file import gather, parse_assignment, read_parameter_file, scenario_file

Scene = Callable[[Path], object]
"""Is called in an empty folder, and raises an error."""


def file(content: str | bytes, name: str = "params.yaml") -> Scene:
    """Reading a parameter file."""

    def scene(folder: Path) -> object:
        path = folder / name
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        return read_parameter_file(path)

    return scene


def loop(folder: Path) -> object:
    (folder / "loop").symlink_to("loop")
    return read_parameter_file(folder / "loop")


def given(**parameters: object) -> Scene:
    return lambda folder: Scenario.from_parameters(parameters)


def assigned(text: str, option: str = "-p") -> Scene:
    return lambda folder: Scenario.from_parameters(dict([parse_assignment(text, option)]))


def asked(name: str, *values: object, **named: object) -> Scene:
    """A method of a scenario, called."""
    return lambda folder: getattr(Scenario(), name)(*values, **named)


FAST = [1e12, 1e12, 0.0]
REFUSED = [
    ("", "is not a parameter file"),
    ("- 1\n- 2\n", "is not a parameter file"),
    ("just words", "is not a parameter file"),
    ("/**:\n  ros__parameters:\n    rate: [1.0\n", "line 4, column 1: not readable as YAML"),
    ("/**:\n\tros__parameters:", "line 2, column 1: not readable as YAML"),
    ("/**:\n  ros__parameters:\n    rate: 1.0\n    rate: 2.0\n", "line 4, column 5: .*'rate' is given twice"),
    ("/**:\n  ros__parameters:\n    rate:\n", "line 3.*a value is missing"),
    ("/**: {ros__parameters: {[1, 2]: 3}}", "a key is not a word"),
    ("rate: 1.0\n", "'rate' stands outside of 'ros__parameters:'"),
    ("{}", "has no 'ros__parameters:'"),
    ("ros__parameters:\n  rate: 1.0\n", "stands at the top"),
    ("/**:\n  ros__parameters: 3\n", "of /\\*\\* holds 3"),
    ("talker: {ros__parameters: {a: 1}}\n/x/*: {ros__parameters: {a: 1}}", "only for /talker, /x/\\*"),
    ("/**: {ros__parameters: {a: !!python/object:os.system 1}}", "not readable as YAML"),
    ("/**: {ros__parameters: {a: *b}}", "aliases .* are not read"),
    ("--- 1\n--- 2\n", "not readable as YAML"),
    ("\x07", "not readable as YAML"),
    ("[" * 5000, "not readable as YAML"),
]
SAID: list[tuple[Scene, str]] = [
    *((file(text), words) for text, words in REFUSED),
    (file(b"\xff\xfe\x00"), "not UTF-8"),
    (lambda folder: read_parameter_file(folder / "none.yaml"), "does not exist"),
    (read_parameter_file, "is a folder"),
    (loop, "cannot be read: Too many levels"),
    (lambda folder: read_parameter_file(folder / "nul\0l"), "cannot be read: embedded null"),
    (lambda folder: Scenario.from_parameters(gather(None, [], ["other:rate:=40.0"])), "no such parameter"),
    (lambda folder: Scenario.from_parameters(5), "parameters 5 are no mapping"),  # type: ignore[arg-type]
    (
        lambda folder: scenario_file("dzanibekov"),
        r"did you mean dzhanibekov or slow_dzhanibekov\?; 'scenarios' lists all$",
    ),
    (assigned("rate=3"), "is not NAME:=VALUE: give for example"),
    (assigned("inertia:=[1.0"), r"^-p 'inertia:=\[1.0', line 1, column 5: not readable as YAML"),
    (assigned(f"rate:=0x{10**5 * 'F'}"), "too large"),
    (assigned("inertia = [" + "1.0, " * 200 + "]", "--set"), "is not NAME:=VALUE: give for example --set rate:=200.0$"),
    (assigned("epoch_ns:=" + "9" * 30), r"epoch_ns: .* is outside \[0, 2147483647000000000\]: give for example 0"),
    (given(initial_body_rate=FAST, rate=1e-6), r"initial_body_rate: .* dmv20 takes \S*e\+18 steps between samples"),
    (
        given(method="rkmk4", max_step=10.0, rate=0.1, initial_body_rate=[3.0, 0.5, -0.9]),
        r"max_step: 10 s lets the body turn by up to \d\d\.\d rad in one.*: give at most \S+ s, or use closed_form",
    ),
    (given(gyro_rate="integrated", initial_body_rate=[0.0, 0.0, 30.0], imu_rate=9.0), "imu_rate: 9 Hz .*give at least"),
    (asked("frame", "imu_frames"), r"^imu_frames: no such parameter: did you mean imu_frame"),
    (asked("frame", "rate"), r"^rate: no such parameter: the parameters are body_frame, imu_frame"),
    (asked("frame", ["body_frame"]), r"^\['body_frame'\]: no such parameter"),
    *(
        (asked(name, *before, rate=rate), f"^rate: {words}")
        for name, before in (("resampled", ()), ("steps_per_sample", ()), ("batch_size", (9, 9)))
        for rate, words in ((math.nan, "nan is not finite"), (0.0, "0 is outside"), ("x", "'x' is not a number"))
    ),
    (asked("resampled", rate=np.zeros((0, 3))), r"^rate: \[\] is not a number"),
    (asked("resampled", epoch_ns=1.5), "^epoch_ns: 1.5 is not an integer"),
    (asked("batch_size", "x", 1), "^at_most: 'x' is no whole number from 1 on"),
    (asked("batch_size", 1, 0), "^steps: 0 is no whole number from 1 on"),
]


@pytest.mark.parametrize(("scene", "words"), SAID, ids=[words[:40] for _, words in SAID])
def test_what_is_said(scene: Scene, words: str, tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        scene(tmp_path)
    assert re.search(words, str(caught.value))
    assert "\n" not in str(caught.value)


IMU_OFF = "no effect, as imu_rate is 0: give what switches it on"
WITHOUT_EFFECT: list[tuple[dict[str, object], list[str]]] = [
    ({"gyro_spike_probability": 0.1}, [f"gyro_spike_probability has {IMU_OFF}"]),
    (
        {"gyro_rate": "integrated", "gyro_range": 9.0, "imu_outage_duration": 0.1, "sun_sensor_noise": 0.1},
        [f"gyro_rate and 2 more have {IMU_OFF}", f"sun_sensor_noise has {IMU_OFF.replace('imu', 'sun_sensor')}"],
    ),
    (
        {"imu_rate": 9.0, "imu_heading_noise": 0.1, "fault_end": 5.0},
        [
            f"imu_heading_noise has {IMU_OFF.replace('imu_rate is 0', 'imu_orientation is false')}",
            "fault_end has no effect, as no fault that comes and goes is on: give what switches it on",
        ],
    ),
]


@pytest.mark.parametrize(("given", "said"), WITHOUT_EFFECT, ids=[said[0][:40] for _, said in WITHOUT_EFFECT])
def test_what_has_no_effect_is_said(given: dict[str, object], said: list[str]) -> None:
    assert Scenario.from_parameters(given).without_effect == said
