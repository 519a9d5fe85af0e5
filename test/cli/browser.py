"""A Chromium without a window, driven through the pipe of its DevTools protocol."""

from __future__ import annotations

import itertools
import json
import os
import select
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
PROGRAM = next(filter(None, map(shutil.which, NAMES)), None)
DEADLINE = 300.0
"""Time, s, after which something is wrong, however slow the machine."""
OPTIONS = (
    *("--headless=new", "--no-sandbox", "--no-first-run", "--remote-debugging-pipe"),
    *("--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-gpu-compositing"),
    *("--disable-background-networking", "--host-resolver-rules=MAP * ~NOTFOUND"),
    "--blink-settings=defaultFontSize=8",
)
"""WebGL, and nothing else, by software that stands for a graphics card, as a machine of tests has none; nothing of the
network is found; half the usual size, that there is less to draw."""


class Browser:
    """A page in a browser, as a context manager.

    Parameters
    ----------
    folder : Path
        For the browser's own files.
    """

    def __init__(self, folder: Path) -> None:
        assert PROGRAM
        commands, self._commands = os.pipe()
        answers, written = os.pipe()
        # it reads from descriptor 3, and writes to 4; dash knows no descriptors of two digits
        script = f'exec "$0" "$@" 3<&{commands} 4>&{written}'
        arguments = [*OPTIONS, f"--user-data-dir={folder}", "about:blank"]
        self._process = subprocess.Popen(
            ["bash", "-c", script, PROGRAM, *arguments], pass_fds=(commands, written), stdout=-3, stderr=-3
        )
        os.close(commands)
        os.close(written)
        self._answers = answers
        self._rest, self._numbers, self._session = b"", itertools.count(1), ""
        self.complaints: list[str] = []
        """Errors and warnings of the console, and exceptions."""
        self.requests: list[str] = []
        """What was loaded."""

    def __enter__(self) -> Browser:
        target = next(t for t in self.call("Target.getTargets")["targetInfos"] if t["type"] == "page")["targetId"]
        self._session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log", "Network"):
            self.call(f"{domain}.enable")
        return self

    def __exit__(self, *failure: object) -> None:
        self._process.terminate()
        try:
            self._process.wait(DEADLINE)
        except subprocess.TimeoutExpired:
            self._process.kill()
        os.close(self._commands)
        os.close(self._answers)

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        """The answer to a command."""
        number = next(self._numbers)
        self._send(number, method, parameters)
        answer = self._await(lambda message: message.get("id") == number)
        assert "error" not in answer, answer
        found: dict[str, Any] = answer["result"]
        return found

    def _send(self, number: int, method: str, parameters: dict[str, Any]) -> None:
        command = {"id": number, "method": method, "params": parameters}
        command |= {"sessionId": self._session} if self._session else {}
        os.write(self._commands, json.dumps(command).encode() + b"\0")

    def _await(self, wanted: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
        while True:
            while b"\0" not in self._rest:
                assert select.select([self._answers], [], [], DEADLINE)[0], "the browser says nothing"
                part = os.read(self._answers, 1 << 20)
                assert part, "the browser has ended"
                self._rest += part
            line, _, self._rest = self._rest.partition(b"\0")
            message: dict[str, Any] = json.loads(line)
            self._note(message.get("method"), message.get("params", {}))
            if wanted(message):
                return message

    def _note(self, method: str | None, told: dict[str, Any]) -> None:
        if method == "Runtime.exceptionThrown":
            self.complaints.append(str(told["exceptionDetails"]))
        elif method == "Runtime.consoleAPICalled" and told["type"] in ("error", "warning", "assert"):
            self.complaints.append(str([argument.get("value") for argument in told["args"]]))
        elif method == "Log.entryAdded" and told["entry"]["level"] in ("error", "warning"):
            self.complaints.append(told["entry"]["text"])
        elif method == "Network.requestWillBeSent":
            self.requests.append(told["request"]["url"][:100])

    def open(self, path: Path, width: int = 1280, height: int = 900) -> None:
        """Open a file, and wait until it is loaded."""
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)
        self._send(0, "Page.navigate", {"url": path.resolve().as_uri()})
        self._await(lambda message: message.get("method") == "Page.loadEventFired")

    def evaluate(self, expression: str) -> Any:
        """The value of an expression in the page; of a promise, what it resolves to."""
        options = {"expression": expression, "awaitPromise": True, "returnByValue": True}
        answer = self.call("Runtime.evaluate", **options)
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    def mouse(self, kind: str, x: float, y: float, *, held: bool = True) -> None:
        """Press, move or release the left button."""
        button = "left" if held or kind == "Released" else "none"
        state = {"button": button, "buttons": int(held and kind != "Released"), "clickCount": int(kind != "Moved")}
        self.call("Input.dispatchMouseEvent", type=f"mouse{kind}", x=x, y=y, **state)
