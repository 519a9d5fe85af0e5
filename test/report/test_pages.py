"""``check --report``: one page that opens offline, in a real browser, with a body that can be turned and played."""

from __future__ import annotations

import json
import os
import re
import sys
from dataclasses import replace
from functools import partial
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import PROGRAM, Browser
from tampering import at, on, tamper, with_numbers
from test_check import write_bag

from lie_rigid_body.certificate import certify
from lie_rigid_body.cli.check import main
from lie_rigid_body.mechanics import State
from lie_rigid_body.messages.batch import BatchEncoder
from lie_rigid_body.recording.bag_reader import read_bag
from lie_rigid_body.recording.bag_writer import BagWriter
from lie_rigid_body.report import figures as of_pages
from lie_rigid_body.report import html_page, write_report
from lie_rigid_body.report.answer import Table, as_page
from lie_rigid_body.report.drawing import BLUE, draw_curve, of_axes, svg
from lie_rigid_body.report.html_page import badge, escaped, paragraph, table
from lie_rigid_body.report.overview import Verdict, page_of_verdicts
from lie_rigid_body.report.recorded_motion import ResidualsOverTime, path, recorded_segments
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Simulation, SimulationStep
from sampled import sampled
from untyped import simulate

LARGEST = 6_000_000
HOSTILE = "x</script><img/src=x/onerror=document.title='taken'><script>document.title='taken'</script>"
pytest.importorskip("plotly")


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A bag that tries to get a script of its own into the page, by its name and by what it declares."""
    path = tmp_path_factory.mktemp("report") / "<img src=x onerror=document.title='taken'>.mcap"
    parameters = {"motion": "closed_form", "world_frame": HOSTILE, "inertia": [1.4, -0.2, 0.4, 1.2, -0.1, 1.6]}
    return write_bag(path, 400, **parameters)


@pytest.fixture(scope="module")
def report(bag: Path) -> Path:
    out = bag.with_name("report.html")
    assert main([str(bag), "--report", str(out)]) == 0
    return out


def film(text: str) -> dict[str, Any]:
    """What plotly.js draws on a page."""
    [content] = re.findall(r'<script type="application/json">(.*?)</script>', text, re.DOTALL)
    return dict(json.loads(content))


def headings(text: str) -> set[str]:
    """Headings of the figures of a page."""
    return set(re.findall("<h3>([^<]*)</h3>", text))


def drawn_of(law: str, path: Path) -> Any:
    """Axes of the residuals of a law of a bag."""
    residuals = ResidualsOverTime()
    certificate = certify(read_bag(path), watch=residuals)
    pieces = recorded_segments(read_bag(path))
    series = residuals.series(law, int(pieces[0].stamps_ns[0]))
    [of_law] = [each for each in certificate.laws if each.name == law]
    return of_axes(partial(of_pages.draw_law, law=of_law, series=series, pieces=pieces)).axes[0]


def curves_of(axes: Any) -> dict[str, Any]:
    """Curves of axes by their labels."""
    return {line.get_label(): line for line in axes.get_lines()}


def test_one_file_holds_everything(report: Path) -> None:
    from plotly.graph_objects import Figure

    text = report.read_text(encoding="utf-8")
    assert report.stat().st_size <= LARGEST
    for wanted in ("CERTIFIED", "attitude", "&quot;inertia&quot;", "default-src 'none'"):
        assert wanted in text
    assert {"The body", "Polhode", "Herpolhode", "kinetic energy", "world momentum"} <= headings(text)
    own = text[: text.index("plotly.js v")]
    assert "<img" not in own
    assert own.count("</script>") == 1
    assert own.count("<svg") > 5
    content = film(text)
    Figure({name: content[name] for name in ("data", "layout")})  # which refuses what plotly.js does not know


def test_what_controls_a_terminal_or_the_direction_of_a_line_stands_as_an_escape() -> None:
    text = "\x1b[2J\u202eabc<b>\0"
    parts = [paragraph(text), badge(text, passed=True), table((text,), [(text,)], ()), escaped(text)]
    assert all("\\x1b[2J\\u202eabc&lt;b&gt;\\x00" in part for part in parts)
    assert escaped("two\nlines") == "two\nlines"
    titled = html_page.document(f"{text} {os.fsdecode(bytes([255]))}.mcap", [], with_film=False).decode()
    assert "&lt;b&gt;\\x00 \\udcff.mcap</h1>" in titled
    assert not any(character in titled for character in "\x1b\u202e")
    assert "script-src 'none'" in titled


@pytest.mark.long
@pytest.mark.skipif(PROGRAM is None, reason="chromium is not installed")
def test_a_browser_opens_plays_and_turns_it(bag: Path, report: Path, tmp_path: Path) -> None:
    with Browser(tmp_path) as browser:
        browser.open(report, 320, 700)  # small, as the graphics are in software
        browser.evaluate("[body, slider] = [document.querySelector('.plot.body'), document.querySelector('input')], 0")
        browser.evaluate("body.scrollIntoView()")
        assert browser.evaluate("slider.value") == "0"
        press(browser, "document.querySelector('button')")
        shown = "done(document.querySelector('output').value)"
        moved = f"new Promise(done => setInterval(() => slider.value > 0 && {shown}))"
        assert browser.evaluate(moved) not in ("", "0 s")
        eye = "JSON.stringify(body.layout.scene.camera.eye)"
        before = browser.evaluate(eye)
        x, y = middle(browser, "body.querySelector('canvas')")
        browser.mouse("Moved", x, y, held=False)
        browser.mouse("Pressed", x, y)
        for step in range(1, 4):
            browser.mouse("Moved", x + 20 * step, y)
        browser.mouse("Released", x + 60, y)
        assert browser.evaluate(eye) != before
        press(browser, "document.querySelector('button')")
        assert browser.evaluate("document.querySelector('button').textContent") == "▶ play"
        assert browser.evaluate("document.querySelectorAll('figure > svg').length") > 5
        assert bag.name in browser.evaluate("document.title")
        assert browser.requests == [report.resolve().as_uri()[:100]]
        # plotly.js reads back text of the 3-D scene, and the page its pictures; to say so is the browser's way
        known = ("Canvas2D: Multiple readback", "GPU stall due to ReadPixels")
        assert [said for said in browser.complaints if not any(words in said for words in known)] == []


@pytest.mark.long
@pytest.mark.skipif(PROGRAM is None, reason="chromium is not installed")
def test_a_long_table_shows_all_of_its_rows(tmp_path: Path) -> None:
    lines = Table(("run",), [(f"run {k}",) for k in range(60)])
    (tmp_path / "runs.html").write_bytes(as_page("Runs", [lines]))
    with Browser(tmp_path / "browser") as browser:
        browser.open(tmp_path / "runs.html")
        browser.evaluate("[box, rows] = [document.querySelector('.table'), document.querySelectorAll('tbody tr')], 0")
        assert browser.evaluate("rows.length") == 60
        for media, overflow in (("screen", "auto"), ("print", "visible")):
            browser.call("Emulation.setEmulatedMedia", media=media)
            assert browser.evaluate("getComputedStyle(box).overflowX") == overflow
            assert browser.evaluate("rows[59].getBoundingClientRect().bottom <= box.getBoundingClientRect().bottom + 1")


def middle(browser: Browser, element: str) -> tuple[float, float]:
    x, y = browser.evaluate(f"(r => [r.x + r.width / 2, r.y + r.height / 2])({element}.getBoundingClientRect())")
    return x, y


def press(browser: Browser, element: str) -> None:
    x, y = middle(browser, element)
    browser.mouse("Moved", x, y, held=False)
    browser.mouse("Pressed", x, y)
    browser.mouse("Released", x, y)


def refused(capsys: pytest.CaptureFixture[str], *arguments: object) -> str:
    assert main([str(argument) for argument in arguments]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    return err


def test_a_page_is_kept_and_refused_before_the_work(
    bag: Path, report: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    before = report.read_bytes()
    nothing = tmp_path / "absent.mcap"
    refused(capsys, nothing, "--report", report)
    assert report.read_bytes() == before
    assert "absent.mcap" in refused(capsys, nothing, "--report", tmp_path / "a.html")
    assert list(tmp_path.iterdir()) == []
    monkeypatch.setitem(sys.modules, "plotly", None)
    capsys.readouterr()
    told = refused(capsys, bag, "--report", tmp_path / "a.html")
    assert "pip install 'lie-rigid-body[report]'" in told


@pytest.mark.slow
def test_the_same_bag_has_a_page_of_the_same_bytes(bag: Path, report: Path) -> None:
    before = report.read_bytes()
    assert main([str(bag), "--report", str(report), "--force", "--json"]) == 0
    assert report.read_bytes() == before


@pytest.mark.slow
def test_a_broken_bag_says_so(tmp_path: Path) -> None:
    bag, out = write_bag(tmp_path / "poor.mcap", 50, method="rkmk1"), tmp_path / "poor.html"
    assert main([str(bag), "--report", str(out)]) == 1
    text = out.read_text(encoding="utf-8")
    assert '"badge broken"' in text
    assert len(curves_of(drawn_of("attitude", bag))["broken"].get_xdata()) > 40


@pytest.mark.slow
@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("number", [np.inf, np.nan, 1e308])
def test_any_recorded_number_makes_a_page(number: float, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    simulation = Simulation(Scenario.from_parameters())
    samples = simulation.take(5)
    rates = np.where(np.arange(5)[:, np.newaxis] == 2, number, samples.states.body_rate)
    samples = replace(samples, states=State.trusted(samples.states.attitude_xyzw, rates))
    with BagWriter(tmp_path / "bag.mcap", stamped_twist=True) as bag:
        bag.begin_segment(simulation.segment)
        bag.write(BatchEncoder(simulation.segment.scenario).encode(SimulationStep(samples)))
    assert main([str(tmp_path / "bag.mcap"), "--report", str(tmp_path / "out.html")]) == 1
    assert capsys.readouterr().err == ""
    for content in re.findall(r"json\">(.*?)</script>", (tmp_path / "out.html").read_text(encoding="utf-8")):
        json.loads(content, parse_constant=lambda name: pytest.fail(f"{name} is no JSON"))


@pytest.mark.filterwarnings("error")
def test_any_estimate_makes_a_page(tmp_path: Path) -> None:
    run = simulate("tumbling_cubesat", duration=2.0, imu_rate=20.0, sensor_grade="mems")
    bias = run.imu.gyro_bias.copy()
    bias[10] = 1e308
    write_report(run.score(run.attitude().at(run.imu.t_ns), gyro_bias=bias), tmp_path / "out.html")
    assert "<svg" in (tmp_path / "out.html").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    "parameters",
    sampled([{"initial_body_rate": [0, 0, 0]}, {"initial_body_rate": [0, 0, 3]}, {"inertia": [2, 2, 2]}], every=3),
)
@pytest.mark.parametrize("count", sampled([1, 30], every=2))
def test_degenerate_motions_make_a_page(parameters: dict[str, Any], count: int, tmp_path: Path) -> None:
    bag = write_bag(tmp_path / "bag.mcap", count, **parameters)
    assert main([str(bag), "--report", str(tmp_path / "out.html")]) == 0


@pytest.fixture(scope="module")
def piece(bag: Path) -> Any:
    [found] = recorded_segments(read_bag(bag))
    return found


def test_the_body_moves_as_it_was_recorded(piece: Any) -> None:
    """The sides of the drawn box keep their lengths, and its principal axes are those of the recorded attitudes."""
    played: Any = of_pages.body(piece)
    content, labels, _ = played
    pictures, body = content["film"]["pictures"], piece.segment.scenario.body()
    assert 100 < len(pictures) <= of_pages.FRAMES
    assert len(labels) == len(pictures)
    for k in (0, len(pictures) // 2, len(pictures) - 1):
        corners = np.stack([pictures[k][name][0] for name in "xyz"], axis=-1)
        sides = [corners[place] - corners[0] for place in (4, 2, 1)]
        lengths = [float(np.linalg.norm(side)) for side in sides]
        assert max(lengths) == pytest.approx(1.0, abs=2e-3)
        at = int(np.searchsorted(piece.stamps_ns, round(float(labels[k].split()[0]) * 1e9)))
        x, y, z, w = piece.states.attitude_xyzw[at]
        first = body.principal_axes[:, 0]
        turned = first + 2.0 * np.cross([x, y, z], np.cross([x, y, z], first) + w * first)
        assert abs(turned @ sides[0]) / lengths[0] == pytest.approx(1.0, abs=1e-3)


def test_the_herpolhode_lies_where_it_must(piece: Any) -> None:
    body, start = piece.segment.scenario.body(), piece.segment.scenario.start()
    drawn: Any = of_pages.herpolhode(piece)
    # ω · L = 2 H fixes the part along the momentum, so |ω| gives the distance from it
    along = 2.0 * body.kinetic_energy(start) / np.linalg.norm(body.angular_momentum(start))
    rates = np.linalg.norm(path(piece, 3000).body_rate, axis=1)
    np.testing.assert_allclose(np.hypot(*drawn.T), np.sqrt(rates**2 - along**2), atol=1e-12)


def test_a_kicked_and_carried_body_has_a_position_and_a_momentum_of_each_arc(tmp_path: Path) -> None:
    kicks = {"initial_body_rate": [0, 0, 0], "kicks": [0.5, 0.3, 1.0, 0.2, 1.5, 0.0, 0.0, 0.0, 2.0, 0.0, 2.0, 0.0]}
    given: dict[str, Any] = {**kicks, "translation": "thrown", "initial_velocity": [1.0, 0.0, 2.0]}
    bag = write_bag(tmp_path / "kicked.mcap", **given)
    assert main([str(bag), "--report", str(tmp_path / "out.html")]) == 0
    content = film((tmp_path / "out.html").read_text(encoding="utf-8"))
    momenta = np.array([[picture[name][4][1] for name in "xyz"] for picture in content["film"]["pictures"]])
    sizes = np.linalg.norm(momenta, axis=1)
    seconds = np.array([float(label.split()[0]) for label in content["times"]])
    largest = np.linalg.norm([0.0, 4.0, 0.0])
    for begin, end, size in ((0.0, 0.5, 0.0), (0.5, 1.5, np.linalg.norm([0.3, 2.0, 0.6])), (1.5, 2.0, 0.0)):
        inside = (seconds > begin + 0.02) & (seconds < end - 0.02)
        assert sizes[inside] == pytest.approx(sizes.max() * size / largest, abs=2e-3)
        assert np.ptp(momenta[inside], axis=0) == pytest.approx(0.0, abs=2e-3)


def test_a_long_curve_keeps_its_peaks_in_a_small_file() -> None:
    t, values = np.linspace(0.0, 7.0, 300_011), np.random.default_rng(0).normal(size=300_011)

    def heights(some: Any) -> Any:
        draw = partial(draw_curve, t_s=t[some], values=values[some], colour=BLUE, label=None)
        text = svg(partial(of_axes, draw))
        assert len(text) < 300_000
        paths = [re.findall(r"[ML] [-.0-9]+ ([-.0-9]+)", path) for path in re.findall(r'<path d="([^"]+)"', text)]
        return np.array(max(paths, key=len), dtype=float)

    ends = [int(values.argmin()), int(values.argmax())]
    every = heights(slice(None))
    few = heights(sorted({*range(0, len(t), 3000), *ends}))
    assert [every.min(), every.max()] == pytest.approx([few.min(), few.max()], abs=0.5)


def test_many_bags_are_one_table(bag: Path, tmp_path: Path) -> None:
    poor = certify(read_bag(write_bag(tmp_path / "poor.mcap", 50, method="rkmk1")))
    good = certify(read_bag(bag))
    text = page_of_verdicts("Bags", [Verdict(bag.name, None, good), Verdict("<b>poor", None, poor)]).decode()
    assert re.search(r">NOT CERTIFIED: of 2 bags 1 ", text)
    assert "<b>poor" not in text
    assert "plotly" not in text
    assert f"{good.attitude_accuracy:.2g}" in text
    assert f"<li>&lt;b&gt;poor: {escape(poor.messages[0])}</li>" in text
    [cells] = re.findall(r"<tr class=broken><td>BROKEN</td><td>50</td><td>(.*?)</td><td>&lt;b&gt;poor</td></tr>", text)
    attitude, law, used = cells.split("</td><td>")
    assert law.split(" [")[0] in {broken.name for broken in poor.laws if not broken.holds}
    assert (float(used) > 1.0, attitude) == (True, "")
    unusable = page_of_verdicts("Bodies", [Verdict("x", "/a", poor), Verdict("x", "/b", None, "no pose")]).decode()
    assert re.search(r">NOT CERTIFIED: of 2 bodies 0 ", unusable)


@pytest.mark.parametrize("number", sampled([np.inf, 123.0], every=2))
def test_a_broken_reading_is_drawn_over_time(number: float, tmp_path: Path) -> None:
    whole, bag, out = tmp_path / "whole.mcap", tmp_path / "spin.mcap", tmp_path / "out.html"
    simulate(duration=1.0, imu_rate=50.0, gyro_resolution=0.001).to_bag(whole)
    spun = at(20, lambda message: with_numbers(message, 24, lambda x: np.append(number, x[1:])))
    assert main([str(tamper(whole, bag, on("/imu/data_raw", spun))), "--report", str(out)]) == 1
    assert out.stat().st_size <= LARGEST
    assert curves_of(drawn_of("gyro", bag))["broken"].get_xdata() == pytest.approx([0.4], abs=0.01)


@pytest.mark.usefixtures("asked_here")
def test_check_of_several_bags_writes_their_page(bag: Path, tmp_path: Path) -> None:
    broken, out = tmp_path / "<i>no.mcap", tmp_path / "many.html"
    broken.write_bytes(b"no bag")
    assert main([str(bag), str(broken), "--report", str(out)]) == 2
    text = out.read_text(encoding="utf-8")
    assert "&lt;i&gt;no.mcap" in text
    assert "<i>no.mcap" not in text
