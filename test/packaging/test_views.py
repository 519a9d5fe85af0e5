"""The views for RViz, Foxglove and PlotJuggler show topics and fields that the node has, and are no scenarios."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from typing import Any
from xml.etree import ElementTree

import yaml
from rosbags.typesys import Stores, get_typestore

from lie_rigid_body.scenario.parameter_file import CONFIG, scenario_files

TYPES = {
    "/pose": "geometry_msgs/msg/PoseStamped",
    "/twist": "geometry_msgs/msg/TwistStamped",
    "/imu/data_raw": "sensor_msgs/msg/Imu",
    "/imu/bias": "sensor_msgs/msg/Imu",
    "/imu/mag": "sensor_msgs/msg/MagneticField",
    "/markers": "visualization_msgs/msg/MarkerArray",
    "/diagnostics": "diagnostic_msgs/msg/DiagnosticArray",
    "/lie_rigid_body/scenario": "std_msgs/msg/String",
}
STORE = get_typestore(Stores.ROS2_JAZZY)
RVIZ = yaml.safe_load((CONFIG / "rviz/lie_rigid_body.rviz").read_text(encoding="utf-8"))
FOXGLOVE = json.loads((CONFIG / "foxglove/lie_rigid_body.json").read_text(encoding="utf-8"))
PLOTJUGGLER = ElementTree.parse(CONFIG / "plotjuggler/lie_rigid_body.xml").getroot()


def assert_number(path: str, separator: str) -> None:
    """A path is a known topic, and a number in its messages."""
    topic = next(topic for topic in TYPES if path.startswith(topic + separator))
    kind: Any = TYPES[topic]
    for name in path.removeprefix(topic + separator).split(separator):
        fields = dict(STORE.get_msgdef(kind).fields)
        assert name in fields, path
        _, kind = fields[name]
        kind = kind[0] if isinstance(kind, tuple) else kind
    assert kind == "float64", path


def displays() -> dict[str, dict[str, Any]]:
    return {display["Class"].rpartition("/")[2]: display for display in RVIZ["Visualization Manager"]["Displays"]}


def test_rviz_shows_markers_pose_frames_and_axes() -> None:
    assert RVIZ["Visualization Manager"]["Global Options"]["Fixed Frame"] == "world"
    assert displays().keys() >= {"MarkerArray", "Pose", "TF", "Axes"}
    assert all(display["Enabled"] for display in displays().values())
    topics = {kind: display["Topic"]["Value"] for kind, display in displays().items() if "Topic" in display}
    assert topics == {"MarkerArray": "/markers", "Pose": "/pose"}


def test_rviz_and_foxglove_show_every_marker() -> None:
    code = (CONFIG.parent / "ros" / "publishing" / "views.py").read_text(encoding="utf-8")
    drawn = set(re.findall(r'"([^"]+)",\s*Marker\.', code))
    assert len(drawn) == 4
    assert set(displays()["MarkerArray"]["Namespaces"]) == drawn
    assert set(FOXGLOVE["configById"]["3D!body"]["topics"]["/markers"]["namespaces"]) == drawn


def panels(layout: Any) -> Iterator[str]:
    """The panels in a layout's tree, and in its tabs."""
    if isinstance(layout, str):
        yield layout
        for tab in FOXGLOVE["configById"][layout].get("tabs", ()):
            yield from panels(tab["layout"])
    else:
        assert layout["direction"] in ("row", "column")
        yield from panels(layout["first"])
        yield from panels(layout["second"])


def test_foxglove_layout_holds_each_panel_once() -> None:
    assert sorted(panels(FOXGLOVE["layout"])) == sorted(FOXGLOVE["configById"])
    kinds = {panel.partition("!")[0] for panel in FOXGLOVE["configById"]}
    assert kinds == {"3D", "Plot", "RawMessages", "DiagnosticSummary", "Tab"}


def test_foxglove_plots_numbers_of_the_topics() -> None:
    plots = [panel for name, panel in FOXGLOVE["configById"].items() if name.startswith("Plot!")]
    paths = [path["value"] for panel in plots for path in panel["paths"]]
    assert {f"/twist.twist.angular.{axis}" for axis in "xyz"} <= set(paths)
    for path in paths:
        assert_number(path, ".")
    assert all(path["timestampMethod"] == "headerStamp" for panel in plots for path in panel["paths"])


def test_foxglove_shows_topics_of_the_node() -> None:
    configured = FOXGLOVE["configById"]
    assert configured["3D!body"]["followTf"] == "world"
    shown = {
        *configured["3D!body"]["topics"],
        configured["RawMessages!scenario"]["topicPath"],
        configured["DiagnosticSummary!node"]["topicToRender"],
    }
    assert shown == {"/markers", "/pose", "/lie_rigid_body/scenario", "/diagnostics"}


def test_plotjuggler_plots_numbers_of_the_topics_that_it_takes() -> None:
    curves = [str(curve.get("name")) for curve in PLOTJUGGLER.iter("curve")]
    for curve in curves:
        assert_number(curve, "/")
    [taken] = [found.get("value") for found in PLOTJUGGLER.iter("selected_topics")]
    topics = str(taken).split(";")
    assert [curve for curve in curves if not any(curve.startswith(f"{topic}/") for topic in topics)] == []
    assert set(topics) <= set(TYPES)
    splitters = list(PLOTJUGGLER.iter("DockSplitter"))
    assert [int(str(s.get("count"))) for s in splitters] == [len(s.findall("DockArea")) for s in splitters]


def test_views_are_no_scenarios() -> None:
    assert {file.parent for file in scenario_files().values()} == {CONFIG}
    assert not {"lie_rigid_body", "policy"} & set(scenario_files())
