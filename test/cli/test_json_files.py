"""``--json OUT.json`` beside ``--json``, of every verb that has it: the same content in a file, the text on stdout."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lie_rigid_body import __main__
from lie_rigid_body.command_line import Parser, json_option
from lie_rigid_body.estimates.programs import lines_of
from lie_rigid_body.runs import Run

WITH_JSON = ("check", "evaluate", "explain", "scenarios", "inspect", "diagnose", "league")
Verb = Callable[[Sequence[str]], int]


@pytest.fixture(scope="module")
def arguments(own: Path, run: Run, tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[str]]:
    """Arguments of each verb, of which all but ``diagnose``, a matter of minutes, answers soon."""
    log, truth = (tmp_path_factory.mktemp("logs") / name for name in ("log.csv", "truth.tum"))
    log.write_text("".join(f"{line.rsplit(',', 3)[0]}\n" for line in lines_of(run)))
    np.savetxt(truth, np.column_stack([run.t_ns / 1e9, np.zeros((len(run.t_ns), 3)), run.truth.attitude_xyzw]))
    return {
        "check": [str(own)],
        "evaluate": [str(truth), "--estimate", str(truth)],
        "explain": ["dzhanibekov"],
        "inspect": [str(log)],
    }


def test_these_are_all_of_them(capsys: pytest.CaptureFixture[str]) -> None:
    for verb in __main__.VERBS:
        assert __main__.main([verb, "--help"]) == 0
        assert ("--json [OUT.json]" in capsys.readouterr().out) == (verb in WITH_JSON), verb


@pytest.mark.usefixtures("undiagnosed")
@pytest.mark.parametrize("verb", [verb for verb in WITH_JSON if verb != "diagnose"])
def test_the_file_has_what_stdout_would_have_and_stdout_what_it_has_without(
    verb: str, arguments: dict[str, list[str]], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    main: Verb = import_module(f"lie_rigid_body.cli.{verb}").main
    given = arguments.get(verb, [])
    path = tmp_path / "out.json"
    status = main([*given, "--json", str(path)])
    assert status in (0, 1)
    assert main([*given, "--json"]) == status
    text, for_programs = capsys.readouterr().out.split(f"wrote {path}\n")
    assert path.read_text() == for_programs
    json.loads(for_programs)
    assert main(given) == status
    assert capsys.readouterr().out == text
    assert main([*given, "--json", str(path)]) == 2  # it is there
    assert capsys.readouterr().out == ""
    assert main([*given, "--json", str(path), "--force"]) == status


@pytest.mark.parametrize(
    ("words", "file", "bags"),
    [
        (["--json", "a.mcap"], "", ["a.mcap"]),
        (["a.mcap", "--json"], "", ["a.mcap"]),
        (["--json", "out.json", "a.mcap"], "out.json", ["a.mcap"]),
        (["a.mcap", "--json=out.JSON"], "out.JSON", ["a.mcap"]),
        (["--json", "--", "out.json"], "", ["out.json"]),
        (["a.mcap"], None, ["a.mcap"]),
    ],
)
def test_a_word_behind_it_is_its_file_where_it_ends_so(words: list[str], file: str | None, bags: list[str]) -> None:
    given: Any = Parser("check", "", (("bags",), {"nargs": "+"}), json_option("")).parse_args(words)
    assert (given.json, given.bags) == (file, bags)


def test_a_file_of_another_kind_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert __main__.main(["explain", "--json=out.txt"]) == 2
    assert "out.txt" in capsys.readouterr().err
