"""Each verb that writes a file, while each of its calls to the disk fails in turn: one line, nothing whole is lost."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

from lie_rigid_body import simulate

SOURCE = Path(__file__).parents[1] / "failing_calls.c"
# Each case is a fork of a process that has loaded everything.
CASES = """
    import ctypes, errno, json, os, sys, traceback
    from pathlib import Path

    library, verbs = ctypes.CDLL(sys.argv[1]), json.loads(sys.argv[2])
    from lie_rigid_body.__main__ import main
    from lie_rigid_body.cli import check, plot, record, recover  # noqa
    from lie_rigid_body.report import certificates, recording_picture  # noqa
    import matplotlib.figure  # noqa

    OLD, KINDS = b"the older file", ("write", "fsync", "read", "close", "rename", "open")

    def tried(command, kind, at, error, sticky, part):
        for path in Path("out").iterdir():
            path.unlink()
        replaced = Path(command[command.index("--force") - 1]) if "--force" in command else None
        if replaced:
            replaced.write_bytes(OLD)
        reader, writer = os.pipe()
        if (pid := os.fork()) == 0:
            status = 98
            try:
                for descriptor, name in ((1, "said"), (2, "complained")):
                    os.dup2(os.open(name, os.O_CREAT | os.O_WRONLY | os.O_TRUNC), descriptor)
                sys.argv = ["lie-rigid-body", *command]
                library.fail(kind, at, error, sticky, part.encode())
                status = main()
            except BaseException:
                traceback.print_exc()
            finally:
                os.write(writer, b"%d" % library.calls())
                sys.stderr.flush()
                os._exit(status)
        count = int(os.read(reader, 20))
        os.close(reader), os.close(writer)
        status = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
        lines, left = Path("complained").read_text().splitlines(), sorted(os.listdir("out"))
        if status == 2:
            assert len(lines) == 1 and ": error: " in lines[0] and "bug" not in lines[0], lines
            assert not any(name.endswith(".part") for name in left), left
            assert not replaced or replaced.read_bytes() == OLD
        else:
            assert (status, lines) == (0, []), (status, lines)
        return count, status

    failed = 0
    for command in verbs:
        for kind, name in enumerate(KINDS):
            part = "/in/" if name == "read" else "out/"
            error = errno.ENOSPC if name in ("write", "open") else errno.EIO
            count, status = tried(command, kind, 0, error, 0, part)
            assert status == 0
            for at in sorted({*range(1, 4), count // 2, *range(count - 2, count + 1)} & {*range(1, count + 1)}):
                for sticky in (0, 1):
                    try:
                        failed += tried(command, kind, at, error, sticky, part)[1] == 2
                    except AssertionError as fault:
                        print(command, name, at, "of", count, sticky, fault)
                        raise SystemExit(1)
    print(failed)
"""


@pytest.mark.slow
def test_each_call_to_a_disk_may_fail(tmp_path: Path) -> None:
    compiler, library = shutil.which("cc"), tmp_path / "failing_calls.so"
    if compiler is None or not sys.platform.startswith("linux"):
        pytest.skip("no C compiler is here, or no /proc")
    subprocess.run([compiler, "-shared", "-fPIC", "-o", library, SOURCE, "-ldl"], check=True)
    for name in ("in", "out"):
        (tmp_path / name).mkdir()
    whole = tmp_path / "in" / "whole.mcap"
    simulate(duration=2.0, motion="closed_form", rate=200.0).to_bag(whole)
    (tmp_path / "in" / "cut.mcap").write_bytes(whole.read_bytes()[:-3000])
    small = ["-p", "motion:=closed_form", "-p", "rate:=200.0", "--chunk-size", "20000", "--quiet"]
    verbs = [
        ["record", "--duration", "2", *small, "out/a.mcap"],
        ["record", "--duration", "2", *small, "out/a.mcap", "--force"],
        ["recover", "in/cut.mcap", "-o", "out/a.mcap", "--force"],
        ["plot", "in/whole.mcap", "-o", "out/a.png", "--force"],
    ]
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(CASES), str(library), json.dumps(verbs)],
        cwd=tmp_path,
        env={**os.environ, "LD_PRELOAD": str(library)},
        check=False,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert int(done.stdout.split()[-1]) > 50
