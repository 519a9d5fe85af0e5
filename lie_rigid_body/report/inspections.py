"""Answers about a log of sensors: what is wrong with it, parameters of the simulator, and the repaired readings."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING, Final

import numpy as np

from lie_rigid_body.estimates.programs import lines_of
from lie_rigid_body.foundation.arrays import Array
from lie_rigid_body.foundation.parameters import NS
from lie_rigid_body.foundation.wording import SI, counted, numerals, program
from lie_rigid_body.inspection import Estimated, Inspection
from lie_rigid_body.inspection.findings import HOW
from lie_rigid_body.inspection.inspection import READINGS, streams_of
from lie_rigid_body.inspection.stamps import Stream
from lie_rigid_body.report import answer, html_page
from lie_rigid_body.report.answer import Conclusion, Parts, Picture, Sentences, Table
from lie_rigid_body.report.drawing import BLUE, COLOURS, GREY, ORANGE, RED
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
_SHOWN: Final = (
    "imu_rate",
    "gyro_noise_density",
    "gyro_bias_random_walk",
    "gyro_turn_on_bias",
    "gyro_resolution",
    "gyro_range",
    "accelerometer_noise_density",
    "accelerometer_bias_random_walk",
    "accelerometer_resolution",
    "accelerometer_range",
    "magnetic_field",
    "magnetometer_rate",
    "magnetometer_noise_density",
    "magnetometer_hard_iron",
    "magnetometer_soft_iron",
    "magnetometer_resolution",
    "magnetometer_range",
    "magnetometer_clock_offset",
)
"""Parameters that a log may show."""


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
        Picture(lambda: html_page.grid(_figures(found))),
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
    if "gyro_bias" in told:  # the simulator draws one by its standard deviation
        told["gyro_turn_on_bias"] = Estimated(math.sqrt(np.mean(np.square(told["gyro_bias"].value))), 0.0)
    lines = [
        f"# Sensors as in {name}, by '{program('inspect')}'. What the log does not show is a comment.",
        "/**:",
        f"  {PARAMETERS_KEY}:",
        *(f"    {each}: {_yaml(told.pop(each))}" if each in told else f"    # {each}: not shown" for each in _SHOWN),
        *(f"    # no parameter, but {what}: {_yaml(found)}" for what, found in told.items()),
        "",
    ]
    return "\n".join(lines).encode()


def _yaml(found: Estimated) -> str:
    """Value, and its standard error as a comment; all digits where there is none."""
    errors = np.atleast_1d(found.standard_error)
    if not errors.any():
        return f"{np.asarray(found.value).tolist()}"
    values = [float(f"{value:.6g}") for value in np.atleast_1d(found.value)]
    return f"{values if len(values) > 1 else values[0]}  # ± {numerals(errors, 2)}"


def csv_of(run: Run) -> bytes:
    """Readings as a CSV that `Run.from_log` reads, with all digits."""
    return "\n".join([*lines_of(run), ""]).encode()


def _figures(found: Inspection) -> Iterator[str]:
    """The readings over time; repaired, the Allan deviations of what rests, and the field on each pair of axes."""
    for stream in streams_of(found.run, found.stamps).values():
        yield _curves(found, stream)
    for sensor, stream in streams_of(found.repaired(), found.stamps).items():
        if f"{sensor}_noise_density" in found.sensors:
            yield _allan_deviation(found, stream)
        if f"{sensor}_hard_iron" in found.sensors:
            yield from _fields(found, stream.readings)


def _curves(found: Inspection, stream: Stream) -> str:
    """Readings over time, the rest, the stretch that was compared, and what is broken."""
    sensor = stream.sensor
    names = sensor, READINGS[sensor][0], "log"
    codes = [mistake.code for mistake in found.mistakes if mistake.sensor in names]
    unit = "?" if f"{sensor}_units" in codes else SI[sensor]
    begin_ns = min(stamps[0] for stamps in found.stamps.values())

    def draw(axes: Axes) -> None:
        for values, colour, name in zip(stream.readings.T, COLOURS, "xyz", strict=True):
            axes.plot((stream.t_ns - begin_ns) / NS, values, color=colour, lw=0.8, label=name)
        for mark in found.marks:
            if mark.sensor in names:
                colour, alpha, shade = _SHADES.get(mark.text, _BROKEN)
                begin_s = (mark.begin_ns - begin_ns) / NS
                end_s = (mark.end_ns - begin_ns) / NS
                is_labelled = shade in axes.get_legend_handles_labels()[1]
                axes.axvspan(begin_s, end_s, color=colour, alpha=alpha, label=None if is_labelled else shade)
        axes.margins(x=0.0)
        axes.set(xlabel="time [s]", ylabel=f"readings [{unit}]")

    return html_page.plane(": ".join([sensor, *codes]), draw)


def _allan_deviation(found: Inspection, stream: Stream) -> str:
    """The Allan deviation of a sensor at rest, with the fit of white noise and a random walk."""
    (rest,) = (mark for mark in found.marks if mark.text == "rest")
    still = stream.between(rest.begin_ns, rest.end_ns)
    measured = allan(still.readings, still.step_s)
    fitted = density(measured)

    def draw(axes: Axes) -> None:
        axes.loglog(measured.tau_s, np.sqrt(measured.variance), "o", color=BLUE, ms=4, label="measured")
        model = np.sqrt(fitted.white**2 / measured.tau_s + fitted.walk**2 * measured.tau_s / 3.0)
        axes.loglog(measured.tau_s, model, color=ORANGE, label="white noise and random walk")
        axes.set(xlabel="averaging time [s]", ylabel=f"Allan deviation [{SI[stream.sensor]}]")
        axes.xaxis.set_minor_formatter("")

    return html_page.plane(f"Allan deviation of the {stream.sensor}", draw)


def _fields(found: Inspection, field: Array) -> Iterator[str]:
    """The field on each pair of axes, before and after hard and soft iron are taken off, and a circle of its size."""
    soft = found.sensors.get("magnetometer_soft_iron")
    matrix = np.eye(3) if soft is None else np.linalg.inv(np.reshape(soft.value, (3, 3)))
    after = (field - found.sensors["magnetometer_hard_iron"].value) @ matrix.T
    some = slice(None, None, max(len(field) // 1000, 1))

    def draw(axes: Axes, i: int, j: int) -> None:
        from matplotlib.patches import Circle

        radius = 1e6 * np.median(np.linalg.norm(after, axis=1))
        axes.add_patch(Circle((0.0, 0.0), radius, fill=False, lw=0.8, label="size of the field"))
        for points, colour, label in ((field, ORANGE, "before"), (after, BLUE, "after")):
            axes.plot(*(1e6 * points[some, [i, j]].T), ".", color=colour, ms=2, label=label)
        axes.set(xlabel=f"{'xyz'[i]} [µT]", ylabel=f"{'xyz'[j]} [µT]", aspect="equal", adjustable="datalim")

    for i, j in ((0, 1), (1, 2), (2, 0)):
        yield html_page.plane(f"Magnetic field on {'xyz'[i]} and {'xyz'[j]}", partial(draw, i=i, j=j))
