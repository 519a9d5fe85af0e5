"""The cluster that a campaign starts is reached from this machine alone, and by nobody who lacks its keys."""

from __future__ import annotations

import gc
import http.client
import os
import socket
import ssl
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import nullcontext, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import pytest
from campaigns import NEEDS_DASK

from lie_rigid_body.campaign.cluster import client_of
from lie_rigid_body.foundation.errors import BagError
from lie_rigid_body.system import console

if TYPE_CHECKING:
    from distributed import Client

pytestmark = NEEDS_DASK
WORKERS = 2
DEADLINE = 300.0


class Own(NamedTuple):
    """A cluster of a campaign: its client, and what its processes listen on."""

    client: Client
    sockets: set[tuple[str, int]]
    shared: Path
    """The folder for temporary files, in which Dask would have one that is that of whoever makes it first."""


def listening() -> dict[int, set[tuple[str, int]]]:
    """Addresses and ports of TCP that this process and its children listen on, by their numbers."""
    psutil: Any = pytest.importorskip("psutil")
    own = psutil.Process()
    found = {}
    for process in (own, *own.children(recursive=True)):
        with suppress(psutil.NoSuchProcess):
            sockets = process.net_connections("inet")
            found[process.pid] = {tuple(each.laddr) for each in sockets if each.status == psutil.CONN_LISTEN}
    return found


@pytest.fixture(scope="module")
def own(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Own]:
    before, path, shared = set().union(*listening().values()), [*sys.path], tmp_path_factory.mktemp("shared")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tempfile, "tempdir", str(shared))
        patch.setenv("TMPDIR", str(shared))
        with client_of(WORKERS, None) as client:
            there = listening()
            workers = {worker["pid"] for worker in client.run(_process).values()}
            assert len(workers & set(there)) == WORKERS  # processes of their own, whose end costs their run only
            assert all(there[worker] for worker in workers)
            [*left] = client.run(_leave_a_program).values()
            yield Own(client, set().union(*there.values()) - before, shared)
    assert sys.path == path
    assert [*shared.iterdir()] == []
    assert not [pid for pid in left if is_running(pid)]  # though each has a session of its own
    assert listening().keys() & workers == set()


def test_no_folder_that_others_share_is_used(own: Own) -> None:
    """Modules of Dask's own would be imported, and its lock waited for."""
    there = own.shared / "dask-scratch-space"
    for path in (sys.path, *own.client.run(_path).values()):
        assert not [place for place in path if place.startswith(str(there))]
    assert [*own.shared.iterdir()]
    assert not there.exists()


def _path() -> list[str]:
    import sys

    return sys.path


def _process() -> dict[str, int]:
    import os

    return {"pid": os.getpid()}


def _leave_a_program() -> int:
    import subprocess

    return subprocess.Popen(["sleep", "600"], start_new_session=True).pid


def is_running(pid: int) -> bool:
    psutil: Any = pytest.importorskip("psutil")
    with suppress(psutil.NoSuchProcess):
        return bool(psutil.Process(pid).status() != psutil.STATUS_ZOMBIE)
    return False


def test_nothing_listens_beyond_this_machine(own: Own) -> None:
    assert len(own.sockets) > WORKERS
    assert {address for address, _ in own.sockets} <= {"127.0.0.1", "::1"}


def test_who_lacks_the_keys_is_refused(own: Own) -> None:
    """Without TLS, without a certificate, and with one of another cluster."""
    from distributed import Security

    nobody = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    nobody.check_hostname, nobody.verify_mode = False, ssl.CERT_NONE
    other = Security.temporary().get_connection_args("client")["ssl_context"]
    other.check_hostname, other.verify_mode = False, ssl.CERT_NONE
    known = own.client.security.get_connection_args("client")["ssl_context"]
    for address in (own.client.scheduler.address, *own.client.scheduler_info()["workers"]):
        assert address.startswith("tls://127.0.0.1:")
        port = int(address.rpartition(":")[2])
        assert [is_greeted(port, context) for context in (known, None, nobody, other)] == [True, False, False, False]


def is_greeted(port: int, context: ssl.SSLContext | None) -> bool:
    """Whether who connects gets a message of Dask: 8 bytes that tell its length begin it."""
    with (
        suppress(OSError),
        socket.create_connection(("127.0.0.1", port), timeout=10) as plain,
        context.wrap_socket(plain) if context else nullcontext(plain) as stream,
    ):
        stream.sendall(bytes(8))
        return len(stream.recv(64)) >= 8
    return False


@pytest.mark.slow
def test_no_page_is_served(own: Own) -> None:
    """Of a dashboard, and of the programs that Dask answers by HTTP, of which some change the cluster."""
    answers = set()
    for host, port in own.sockets:
        for method, path in (("GET", "/"), ("GET", "/status"), ("GET", "/info"), ("POST", "/api/v1/retire_workers")):
            connection = http.client.HTTPConnection(host, port, timeout=10)
            with suppress(OSError, http.client.HTTPException):
                connection.request(method, path)
                answers.add(connection.getresponse().status)
            connection.close()
    assert answers == {404}


@pytest.mark.skipif(sys.version_info < (3, 11), reason="Python 3.10 imports from its working folder")
def test_its_processes_import_nothing_of_the_working_folder(tmp_path: Path) -> None:
    """It may be a folder that somebody else fills, also with what libraries look for and do not find elsewhere."""
    campaign = "{runs: 1, seed: 1, duration: 0.1, estimator: 'own_one:estimate'}"
    (tmp_path / "campaign.yaml").write_text(campaign, encoding="utf-8")
    (tmp_path / "own_one.py").write_text("def estimate(run): return run.truth.attitude_xyzw", encoding="utf-8")
    for name in ("signal", "socket", "pickle", "threading", "multiprocessing", "gilknocker", "crick", "msvcrt", "rmm"):
        (tmp_path / f"{name}.py").write_text("open('imported', 'w')", encoding="utf-8")
    verb = [
        "import sys; sys.path[:] = filter(None, sys.path); from lie_rigid_body.__main__ import main; sys.exit(main())",
        "campaign",
    ]
    command = [sys.executable, "-c", *verb, "campaign.yaml", "--out", "out", "--workers", "1"]
    plain = {name: value for name, value in os.environ.items() if name != "PYTHONSAFEPATH"}
    done = subprocess.run(
        command, cwd=tmp_path, env=plain, capture_output=True, text=True, timeout=DEADLINE, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert not (tmp_path / "imported").exists()


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no limits of processes here")
def test_a_limit_that_keeps_workers_from_starting_is_one_line(tmp_path: Path) -> None:
    import resource

    def few_files() -> None:
        resource.setrlimit(resource.RLIMIT_NOFILE, (16, 16))  # with which Dask waits for itself

    (tmp_path / "campaign.yaml").write_text("{runs: 1, seed: 1, duration: 0.1}", encoding="utf-8")
    command = [sys.executable, "-m", "lie_rigid_body", "campaign", "campaign.yaml", "--out", "out", "--workers", "1"]
    done = subprocess.run(
        command, cwd=tmp_path, preexec_fn=few_files, capture_output=True, text=True, timeout=DEADLINE, check=False
    )
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert console.DEBUG not in line


def test_a_client_that_failed_is_gone_at_once() -> None:
    """Collected later, in the thread of another client that starts, it would be waited for without an end."""
    from distributed import Client

    def clients() -> int:
        return sum(issubclass(type(each), Client) for each in gc.get_objects())  # no proxy is asked for its class

    gc.collect()
    before = clients()
    gc.disable()
    try:
        with pytest.raises(BagError), client_of(None, "tls://127.0.0.1:1"):
            raise AssertionError
        assert clients() == before
    finally:
        gc.enable()
