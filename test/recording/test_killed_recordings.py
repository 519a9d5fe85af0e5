"""A headless recording killed at random instants: what is recovered is the beginning of the whole, and certified."""

from __future__ import annotations

import itertools
import json
import random
import signal
import statistics
import subprocess
import sys
import textwrap
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from bags import COMPRESSIONS, write_bag
from refused_bags import refused

from lie_rigid_body.certificate import certify
from lie_rigid_body.cli.check import main as check
from lie_rigid_body.foundation.errors import BagError
from lie_rigid_body.messages.batch import BatchEncoder
from lie_rigid_body.recording.bag_reader import read_bag
from lie_rigid_body.recording.bag_writer import BagWriter
from lie_rigid_body.recording.recovery import recover
from lie_rigid_body.scenario import Scenario
from lie_rigid_body.simulation import Simulation

KILLER = """
    import json, os, signal, sys, time
    from pathlib import Path
    from lie_rigid_body.cli.record import main
    from lie_rigid_body.motion.closed_form.solution import compile_all
    from lie_rigid_body.motion.munthe_kaas.loop import LOOP
    from lie_rigid_body.recording.bag_writer import BagWriter

    compile_all(), LOOP.compile()  # else a recording may load them, in a thread beside it, which is no work lost
    write = BagWriter.write

    def told(bag, batch):  # what is computed by now: a file keeps it when the process is killed
        os.write(journal, f"{bag.sample_count + len(batch.topics[0].payloads)} {time.process_time()}\\n".encode())
        write(bag, batch)

    BagWriter.write = told
    for line in sys.stdin:
        path, seconds, arguments = json.loads(line)
        journal = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND)
        child = os.fork()
        if child == 0:
            os._exit(main(arguments))
        while not os.fstat(journal).st_size and not os.waitpid(child, os.WNOHANG)[0]:
            time.sleep(0.001)
        time.sleep(seconds)
        ticks = Path(f"/proc/{child}/stat").read_text().rpartition(")")[2].split()[11:13]
        os.kill(child, 9)
        _, status = os.waitpid(child, 0)
        os.close(journal)
        print(json.dumps([sum(map(int, ticks)) / os.sysconf("SC_CLK_TCK"), status]), flush=True)
"""
"""For each line of its input it forks a recording, and kills it so many seconds after its first batch."""
LONGEST = {"fast": 0.2, "slow": 1.5, "to replace another": 0.2}
"""Times, s, after which a recording is killed at the latest: of a fast one little is to be certified then."""
DURATION = "100000"
"""Duration that is asked for, s, which no recording reaches before it is killed. It needs 1.8 GB of free room."""
RUNS = {
    "fast": ["-p", "motion:=closed_form", "-p", "imu_rate:=50.0", "--duration", DURATION],
    "slow": ["-p", "rate:=1.0", "-p", "method:=rkmk4", "-p", "max_step:=1e-4", "--duration", DURATION],
    "to replace another": ["-p", "motion:=closed_form", "--compression", "lz4", "--duration", DURATION, "--force"],
}


class Killed(NamedTuple):
    """The samples that were recovered, and the processor time, s, of the work that was lost."""

    samples: int
    lost_s: float


def killed(folder: Path, kind: str, seconds: float, killer: subprocess.Popen[str]) -> Killed:
    """Kill a recording, and hold what is recovered of it against what it would have been."""
    folder.mkdir()
    out, journal, old = folder / "out.mcap", folder / "journal", b""
    if "--force" in RUNS[kind]:
        old = write_bag(out, count=5).read_bytes()
    assert killer.stdin is not None
    assert killer.stdout is not None
    killer.stdin.write(json.dumps([str(journal), seconds, [str(out), *RUNS[kind], "--quiet"]]) + "\n")
    killer.stdin.flush()
    used_s, status = json.loads(killer.stdout.readline())
    assert status == signal.SIGKILL
    broken = next(folder.glob(".*.part")) if old else out
    assert out.read_bytes() == old if old else check([str(out)]) == 2
    samples = recovered(broken, folder / "fixed.mcap")
    computed = [(int(count), float(at_s)) for count, at_s in map(str.split, journal.read_text().splitlines())]
    kept_s = max((at_s for count, at_s in computed if count <= samples), default=computed[0][1])
    return Killed(samples, used_s - kept_s)


def recovered(broken: Path, fixed: Path) -> int:
    """The samples of a bag that is certified, from the first one on; 0 if no message is whole."""
    try:
        recover(broken, fixed, overwrite=False)
    except BagError:
        return 0
    recording = read_bag(fixed)
    assert certify(recording).passed
    stamps = recording.poses.stamps_ns
    np.testing.assert_array_equal(stamps, np.arange(len(stamps)) * stamps[1:2].sum())
    return len(stamps)


@pytest.mark.long
@pytest.mark.parametrize("kills", [3, pytest.param(100, marks=pytest.mark.slow)])
def test_what_is_recovered_is_the_beginning(
    tmp_path: Path, kills: int, record_property: Callable[[str, object], None]
) -> None:
    randomness = random.Random(kills)
    command = [sys.executable, "-c", textwrap.dedent(KILLER)]
    with subprocess.Popen(command, stdin=-1, stdout=-1, text=True) as killer:
        found = [
            killed(tmp_path / str(i), kind, randomness.uniform(0.0, LONGEST[kind]), killer)
            for i, kind in zip(range(kills), itertools.cycle(RUNS), strict=False)
        ]
        assert killer.stdin is not None
        killer.stdin.close()
    lost = [each.lost_s for each in found]
    record_property("kills", kills)
    record_property("recovered", sum(each.samples > 0 for each in found))
    record_property("lost at most, s of work", round(max(lost), 3))
    record_property("median, s of work", round(statistics.median(lost), 3))
    assert max(lost) <= 1.0


@pytest.mark.parametrize("compression", COMPRESSIONS)
def test_a_draft_has_all_that_was_written_and_leaves_no_trace(tmp_path: Path, compression: str) -> None:
    scenario = Scenario.from_parameters({"motion": "closed_form", "rate": 1.0, "imu_rate": 2.0})
    for name, drafted in (("drafted", True), ("plain", False)):
        simulation, encoder = Simulation(scenario), BatchEncoder(scenario)
        path = tmp_path / name
        with BagWriter(path, stamped_twist=True, chunk_size=9000, compression=compression) as bag:
            bag.begin_segment(simulation.segment)
            while simulation.next_sample < 60:
                bag.write(encoder.encode(simulation.take_until(simulation.clock.stamp_ns(59), 5)))
                count = simulation.next_sample
                if drafted:
                    bag.draft()
                    bag.require_intact()
                    bag.wait()
                if drafted and count in (5, 35, 55):
                    killed = tmp_path / f"{count}.mcap"
                    killed.write_bytes(path.read_bytes())
                    assert recovered(killed, tmp_path / f"{count}-fixed.mcap") == count
    assert (tmp_path / "drafted").read_bytes() == (tmp_path / "plain").read_bytes()


def test_a_file_that_is_cut_within_a_draft_gets_no_hole(tmp_path: Path) -> None:
    scenario = Scenario.from_parameters({"motion": "closed_form"})
    simulation, path = Simulation(scenario), tmp_path / "cut.mcap"
    bag = BagWriter(path, stamped_twist=True)
    bag.begin_segment(simulation.segment)
    bag.draft()
    bag.wait()
    with path.open("r+b") as file:
        file.truncate(8)
    with refused("another's"):
        bag.finish()
    assert b"\0" * 64 not in path.read_bytes()[:256]
