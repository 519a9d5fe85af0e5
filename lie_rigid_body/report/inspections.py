"""Answers about a log of sensors: what is wrong with it, parameters of the simulator, and the repaired readings."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from lie_rigid_body.estimates.programs import lines_of
from lie_rigid_body.foundation.arrays import Array, Integers
from lie_rigid_body.foundation.wording import SI, counted, numerals, program
from lie_rigid_body.inspection import Estimated, Inspection
from lie_rigid_body.inspection.findings import HOW, Mark
from lie_rigid_body.inspection.inspection import READINGS
from lie_rigid_body.report import answer, html_page
from lie_rigid_body.report.answer import Conclusion, Parts, Picture, Sentences, Table
from lie_rigid_body.report.drawing import BLACK, BLUE, COLOURS, GREY, ORANGE, RED
from lie_rigid_body.runs import Run
from lie_rigid_body.scenario.parameter_file import PARAMETERS_KEY
from lie_rigid_body.sensors.allan import allan, density

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_SHADES: Final = {
    "rest": (BLUE, 0.15, "at rest"),
    "compared": (GREY, 0.10, "stretch that was compared"),
}
_BROKEN: Final = (RED, 0.25, "broken stamps, or a gap")
"""Shades of stretches of time by the texts of their marks, and that of others: colour, opacity and label."""
_HOW: Final = f": {HOW}"
_HEADINGS: Final = ("mistake", "sensor", "repair", "misfit before", "after", "or else")
_SHOWN: Final = {
    "imu": ("rate",),
    "gyro": ("noise_density", "bias_random_walk", "turn_on_bias", "resolution", "range"),
    "accelerometer": ("noise_density", "bias_random_walk", "resolution", "range"),
    "magnetic": ("field",),
    "magnetometer": ("rate", "noise_density", "hard_iron", "soft_iron", "resolution", "range", "clock_offset"),
}
"""Parameters that a log may show: sensors, and the ends of the names."""


def parts_of_inspection(found: Inspection) -> Parts:
    """Answer about what is wrong with a log."""
    log = found.run.log
    rows = [
        (m.code, m.sensor, m.repair, _share(m.before), _share(m.after), ", ".join(m.or_else)) for m in found.mistakes
    ]
    return [
        Sentences(() if log is None else log.taken),
        Conclusion([_headline(found), *(_sentence(m.message) for m in found.mistakes)], found.passed),
        Table(_HEADINGS, rows, "Mistakes"),
        Sentences(
            [f"{each.code}: {each.message.removesuffix(_HOW)}" for each in found.undecided],
            f"Not decided by this log; one that decides: {HOW}",
        ),
        Sentences([f"{each.code}: {each.message}" for each in found.notes], "Notes"),
        Table(
            ("parameter", "value", "standard error"),
            [
                (name, numerals(np.atleast_1d(each.value), 4), numerals(np.atleast_1d(each.standard_error), 2))
                for name, each in found.sensors.items()
            ],
            "Parameters of the sensors, repaired",
        ),
        Picture(lambda: html_page.grid([*_curves(found), *_allan_deviations(found), *_fields(found)])),
    ]


def as_text(found: Inspection) -> str:
    """Lines of an inspection, for a terminal."""
    return answer.as_text(parts_of_inspection(found))


def _headline(found: Inspection) -> str:
    named = f"{counted(len(found.mistakes), 'mistake')} found" if found.mistakes else "No mistake found"
    left = f"; {counted(len(found.undecided), 'code')} not decided by this log" if found.undecided else ""
    return f"{named}{left}."


def _sentence(text: str) -> str:
    return f"{text[:1].upper()}{text[1:]}."


def _share(misfit: float | None) -> str:
    return "" if misfit is None else f"{misfit:.2g}"


def parameters_of(sensors: Mapping[str, Estimated], name: str) -> bytes:
    """Parameter file with which the simulator's sensors are like those of a log.

    Parameters
    ----------
    sensors : mapping of str to Estimated
        What an inspection has estimated.
    name : str
        Of the log.
    """
    told = dict(sensors)
    bias = told.pop("gyro_bias", None)
    if bias is not None:  # the simulator draws one by its standard deviation
        told["gyro_turn_on_bias"] = Estimated(math.sqrt(np.mean(np.square(bias.value))), 0.0)
    lines = [
        f"# Sensors as in {name}, by '{program('inspect')}'. What the log does not show is a comment.",
        "/**:",
        f"  {PARAMETERS_KEY}:",
    ]
    for parameter in (f"{sensor}_{end}" for sensor, ends in _SHOWN.items() for end in ends):
        found = told.pop(parameter, None)
        lines.append(f"    # {parameter}: not shown" if found is None else f"    {parameter}: {_yaml(found)}")
    others = {"gyro_bias": bias, **told}
    lines += [f"    # no parameter, but {what}: {_yaml(found)}" for what, found in others.items() if found is not None]
    return "\n".join([*lines, ""]).encode()


def _yaml(found: Estimated) -> str:
    """Value, and its standard error as a comment; all digits where there is none."""
    values = np.atleast_1d(found.value).tolist()
    errors = np.atleast_1d(found.standard_error).tolist()
    if any(errors):
        values = [float(f"{value:.6g}") for value in values]
    text = str(values if isinstance(found.value, tuple) else values[0])
    return f"{text}  # ± {numerals(errors, 2)}" if any(errors) else text


def csv_of(run: Run) -> bytes:
    """Readings as a CSV that `Run.from_log` reads, with all digits."""
    return "\n".join([*lines_of(run), ""]).encode()


def _curves(found: Inspection) -> Iterator[str]:
    """The readings over time, the rest, the stretch that was compared, and what is broken."""
    given = [(sensor, *_readings(found, found.run, sensor)) for sensor in READINGS]
    there = [(sensor, key, t_ns, readings) for sensor, key, t_ns, readings in given if readings is not None]
    begin_ns = min(int(t_ns.min()) for *_, t_ns, _ in there)
    for sensor, key, t_ns, readings in there:
        names = sensor, key, "log"
        codes = [mistake.code for mistake in found.mistakes if mistake.sensor in names]
        unit = "?" if f"{sensor}_units" in codes else SI[sensor]
        marks = [mark for mark in found.marks if mark.sensor in names]
        draw = partial(_draw_readings, t_ns=t_ns, readings=readings, marks=marks, begin_ns=begin_ns, unit=unit)
        yield html_page.plane(": ".join(filter(None, (sensor, ", ".join(codes)))), draw)


def _draw_readings(
    axes: Axes, t_ns: Integers, readings: Array, marks: Sequence[Mark], begin_ns: int, unit: str
) -> None:
    t_s = (t_ns - begin_ns) / 1e9
    for values, colour, name in zip(readings.T, COLOURS, "xyz", strict=True):
        axes.plot(t_s, values, color=colour, lw=0.8, label=name)
    for mark in marks:
        colour, alpha, shade = _SHADES.get(mark.text, _BROKEN)
        ends = ((at - begin_ns) / 1e9 for at in (mark.begin_ns, mark.end_ns))
        is_labelled = shade in axes.get_legend_handles_labels()[1]
        axes.axvspan(*ends, color=colour, alpha=alpha, label=None if is_labelled else shade)
    axes.margins(x=0.0)
    axes.set(xlabel="time [s]", ylabel=f"readings [{unit}]")


def _readings(found: Inspection, run: Run, sensor: str) -> tuple[str, Integers, Any]:
    """Key of a sensor, its repaired stamps, ns, or numbers where no stamps tell a time, and its readings or None."""
    key, array = READINGS[sensor]
    readings = getattr(run.sensors.get(key), array, None)
    return key, found.stamps.get(key, np.arange(0 if readings is None else len(readings))), readings


def _allan_deviations(found: Inspection) -> Iterator[str]:
    """The Allan deviation of each sensor at rest, with the fit of white noise and a random walk."""
    told = [sensor for sensor in READINGS if f"{sensor}_noise_density" in found.sensors]
    for sensor in told:
        yield html_page.plane(f"Allan deviation of the {sensor}", partial(_draw_allan, found=found, sensor=sensor))


def _draw_allan(axes: Axes, found: Inspection, sensor: str) -> None:
    (rest,) = (mark for mark in found.marks if mark.text == "rest")
    _, t_ns, readings = _readings(found, found.repaired(), sensor)
    still = (t_ns >= rest.begin_ns) & (t_ns <= rest.end_ns)
    measured = allan(readings[still], np.median(np.diff(t_ns)) / 1e9)
    fitted = density(measured)
    axes.loglog(measured.tau_s, np.sqrt(measured.variance), "o", color=BLUE, ms=4, label="measured")
    model = np.sqrt(fitted.white**2 / measured.tau_s + fitted.walk**2 * measured.tau_s / 3.0)
    axes.loglog(measured.tau_s, model, color=ORANGE, label="white noise and random walk")
    axes.set(xlabel="averaging time [s]", ylabel=f"Allan deviation [{SI[sensor]}]")
    axes.xaxis.set_minor_formatter("")


def _fields(found: Inspection) -> Iterator[str]:
    """Readings of the magnetometer on each pair of axes, before and after hard and soft iron are taken off."""
    if "magnetometer_hard_iron" not in found.sensors:
        return
    *_, field = _readings(found, found.repaired(), "magnetometer")
    iron = np.asarray(found.sensors["magnetometer_hard_iron"].value)
    soft = found.sensors.get("magnetometer_soft_iron")
    matrix = np.eye(3) if soft is None else np.linalg.inv(np.reshape(soft.value, (3, 3)))
    both = 1e6 * np.stack([field, (field - iron) @ matrix.T])
    for i, j in ((0, 1), (1, 2), (2, 0)):
        draw = partial(_draw_field, both=both, i=i, j=j)
        yield html_page.plane(f"Magnetic field on {'xyz'[i]} and {'xyz'[j]}", draw)


def _draw_field(axes: Axes, both: Array, i: int, j: int) -> None:
    """Draw components of readings of shape (2, N, 3), µT, and a circle of the size of the field."""
    radius = np.median(np.linalg.norm(both[1], axis=1))
    circle = radius * np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 200))
    rows = slice(None, None, max(both.shape[1] // 1000, 1))
    axes.plot(circle.real, circle.imag, color=BLACK, lw=0.8, label="size of the field")
    for points, colour, label in zip(both[:, rows], (ORANGE, BLUE), ("before", "after"), strict=True):
        axes.plot(points[:, i], points[:, j], ".", color=colour, ms=2, label=label)
    axes.set(xlabel=f"{'xyz'[i]} [µT]", ylabel=f"{'xyz'[j]} [µT]", aspect="equal")
    axes.set_adjustable("datalim")
