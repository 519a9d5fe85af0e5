"""Two writers on one path, and file systems that are full or read-only: told in one line, and nothing whole is lost."""

from __future__ import annotations

import errno
import json
import os
import re
import subprocess
import sys
import textwrap
from contextlib import suppress
from pathlib import Path
from threading import Barrier, Thread

import pytest
from bags import write_bag, write_samples

from lie_rigid_body.certificate import certify
from lie_rigid_body.foundation.errors import BagError
from lie_rigid_body.recording.bag_reader import read_bag
from lie_rigid_body.recording.bag_writer import BagWriter
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Simulation
from lie_rigid_body.system.output_file import OutputFile

MOUNT = 'mount -t tmpfs -o "$1" none "$2" && shift 2 && exec "$@"'
"""Of a shell in a mount namespace of its own, where whoever runs it is root."""
RUN = """
    import json, sys
    from lie_rigid_body import LieRigidBodyError, simulate
    from lie_rigid_body.__main__ import main
    for given in json.loads(sys.argv[1]):
        try:
            print(given[0], main(given) if given[0] != "to_bag" else simulate(duration=300.0).to_bag(given[1]))
        except LieRigidBodyError as error:
            print(error, file=sys.stderr)
"""


def elsewhere(there: Path, options: str, *verbs: tuple[str, ...]) -> subprocess.CompletedProcess[str]:
    """Run verbs in this folder, in which another is a file system of its own."""
    there.mkdir()
    python = [sys.executable, "-c", textwrap.dedent(RUN), json.dumps(verbs)]
    namespace = ["unshare", "--mount"] if os.geteuid() == 0 else ["unshare", "--map-root-user", "--mount"]
    try:
        subprocess.run([*namespace, "sh", "-c", MOUNT, "sh", options, there, "true"], check=True, capture_output=True)
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("no file system can be mounted here")
    command = [*namespace, "sh", "-c", MOUNT, "sh", options, str(there), *python]
    return subprocess.run(command, cwd=there.parent, capture_output=True, text=True, check=False)


@pytest.mark.slow
@pytest.mark.long
def test_a_read_only_file_system_is_told_by_each_verb_in_one_line(tmp_path: Path) -> None:
    write_bag(tmp_path / "whole.mcap", count=50)
    (tmp_path / "c.yaml").write_text("runs: 2\nseed: 1\nduration: 1.0\n")
    done = elsewhere(
        tmp_path / "there",
        "ro",
        ("record", "there/a.mcap", "-p", "motion:=closed_form", "--duration", "1"),
        ("recover", "whole.mcap", "-o", "there/b.mcap"),
        ("plot", "whole.mcap", "-o", "there/c.png"),
        ("campaign", "c.yaml", "--out", "there/d"),
    )
    assert done.stdout.split("\n")[:-1] == ["record 2", "recover 2", "plot 2", "campaign 2"], done.stderr
    lines = done.stderr.splitlines()
    assert len(lines) == 4
    assert all(os.strerror(errno.EROFS) in line and len(line) <= 200 for line in lines), lines


@pytest.mark.slow
def test_what_fits_on_a_full_file_system_is_recovered_and_certified(tmp_path: Path) -> None:
    done = elsewhere(
        tmp_path / "there",
        "size=2m",
        ("to_bag", "there/a.mcap"),
        ("recover", "there/a.mcap", "-o", "there/b.mcap"),
        ("recover", "there/a.mcap", "-o", "fixed.mcap"),
        ("check", "there/b.mcap"),
    )
    statuses = [line for line in done.stdout.splitlines() if re.fullmatch(r"\w+ \d", line)]
    assert statuses == ["recover 2", "recover 0", "check 2"]
    assert "there/b.mcap does not exist" in done.stderr
    for name, line in zip("ab", done.stderr.splitlines(), strict=False):
        assert (f"{name}.mcap " in line, os.strerror(errno.ENOSPC) in line) == (True, True)
    recording = read_bag(tmp_path / "fixed.mcap")
    assert len(recording.poses) > 1000
    certificate = certify(recording)
    assert certificate.passed, certificate.messages


def test_of_two_that_begin_a_file_one_has_it(tmp_path: Path) -> None:
    for turn in range(20):
        path, barrier, won = tmp_path / f"{turn}.mcap", Barrier(2), list[OutputFile]()

        def begin(path: Path = path, barrier: Barrier = barrier, won: list[OutputFile] = won) -> None:
            barrier.wait()
            with suppress(BagError):
                won.append(OutputFile(path, overwrite=False))

        threads = [Thread(target=begin) for _ in range(2)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        [file] = won
        file.stream.write(b"whole")
        file.commit()
        assert path.read_bytes() == b"whole"


def test_of_two_that_replace_a_file_the_last_to_finish_has_it_whole(tmp_path: Path) -> None:
    path, scenario = tmp_path / "bag.mcap", Scenario.from_parameters({"motion": "closed_form"})
    write_bag(path, count=3)
    simulations = [Simulation(scenario), Simulation(scenario)]
    bags = [BagWriter(path, stamped_twist=True, overwrite=True) for _ in simulations]
    for count in (100, 50):
        for bag, simulation in zip(bags, simulations, strict=True):
            if count == 100:
                bag.begin_segment(simulation.segment)
            write_samples(bag, scenario, simulation.take(count))
            bag.flush()
            bag.wait()
    bags[1].finish()
    assert read_bag(path).expected_samples == 150
    write_samples(bags[0], scenario, simulations[0].take(10))
    bags[0].finish()
    assert read_bag(path).expected_samples == 160
    assert certify(read_bag(path)).passed
    assert os.listdir(tmp_path) == [path.name]
