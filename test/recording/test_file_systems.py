"""Two writers on one path, and file systems that are full or read-only: told in one line, and nothing whole is lost."""

from __future__ import annotations

import errno
import os
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
VERBS = """
    import os, sys
    from pathlib import Path
    from lie_rigid_body.__main__ import main
    whole, there, campaign = sys.argv[1:]
    Path(campaign).write_text("runs: 2\\nseed: 1\\nduration: 1.0\\n")
    for given in (
        ["record", f"{there}/a.mcap", "--duration", "1", "-p", "motion:=closed_form"],
        ["recover", whole, "-o", f"{there}/b.mcap"],
        ["plot", whole, "-o", f"{there}/c.png"],
        ["campaign", campaign, "--out", f"{there}/d"],
    ):
        print(given[0], main(given), flush=True)
    assert os.listdir(there) == []
"""
FILL = """
    import sys
    from lie_rigid_body.foundation.errors import BagError
    from lie_rigid_body.messages.batch import BatchEncoder
    from lie_rigid_body.recording.bag_writer import BagWriter
    from lie_rigid_body.recording.recovery import recover
    from lie_rigid_body.scenario import Scenario
    from lie_rigid_body.simulation import Simulation
    from pathlib import Path

    whole, there, fixed = map(Path, sys.argv[1:])
    scenario = Scenario.from_parameters({"motion": "closed_form"})
    simulation, encoder = Simulation(scenario), BatchEncoder(scenario)
    try:
        with BagWriter(there / "a.mcap", stamped_twist=True, chunk_size=10_000) as bag:
            bag.begin_segment(simulation.segment)
            while True:
                last_ns = simulation.clock.stamp_ns(simulation.next_sample + 99)
                bag.write(encoder.encode(simulation.take_until(last_ns, 100)))
    except BagError as error:
        print(error)
    try:
        recover(there / "a.mcap", there / "b.mcap", overwrite=False)
    except BagError as error:
        print(error)
    assert not (there / "b.mcap").exists()
    print(recover(there / "a.mcap", fixed, overwrite=False).messages)
"""


def elsewhere(code: str, options: str, whole: Path) -> subprocess.CompletedProcess[str]:
    """Run code on a file system of its own, given the paths of a bag, of that file system, and of another file."""
    there = whole.with_name("there")
    there.mkdir()
    python = [sys.executable, "-c", textwrap.dedent(code), str(whole), str(there), str(whole.with_name("other"))]
    namespace = ["unshare", "--mount"] if os.geteuid() == 0 else ["unshare", "--map-root-user", "--mount"]
    try:
        subprocess.run([*namespace, "sh", "-c", MOUNT, "sh", options, there, "true"], check=True, capture_output=True)
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("no file system can be mounted here")
    command = [*namespace, "sh", "-c", MOUNT, "sh", options, str(there), *python]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.mark.long
def test_a_read_only_file_system_is_told_by_each_verb_in_one_line(tmp_path: Path) -> None:
    done = elsewhere(VERBS, "ro", write_bag(tmp_path / "whole.mcap", count=50))
    assert done.stdout.split("\n")[:-1] == ["record 2", "recover 2", "plot 2", "campaign 2"], done.stderr
    lines = done.stderr.splitlines()
    assert len(lines) == 4
    assert all(os.strerror(errno.EROFS) in line and len(line) <= 200 for line in lines), lines


def test_what_fits_on_a_full_file_system_is_recovered_and_certified(tmp_path: Path) -> None:
    done = elsewhere(FILL, "size=200k", write_bag(tmp_path / "whole.mcap", count=5))
    full, no_room, recovered = done.stdout.splitlines()
    for name, line in (("a.mcap", full), ("b.mcap", no_room)):
        assert (f"{name} " in line, os.strerror(errno.ENOSPC) in line) == (True, True)
    assert int(recovered) > 1000
    certificate = certify(read_bag(tmp_path / "other"))
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
