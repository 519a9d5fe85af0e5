"""Try the package that is installed for this Python as a user would: files, README's first screen, a bag.

    python scripts/try_installed.py [FOLDER]

FOLDER holds the README and package.xml of the release; by default it is the one above this file. Nothing of FOLDER is
imported. The status is 1, and the reason is told, if something is missing or does not say what the README shows.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
import sys
import sysconfig
from importlib import metadata
from pathlib import Path
from tempfile import TemporaryDirectory

ALIKE = 2e-3
"""By how much a number of the score may differ from the README's, relative: the last digit that is shown."""


def main() -> None:
    """Try everything in an empty folder, and tell what was tried."""
    release = Path(sys.argv[1] if sys.argv[1:] else Path(__file__).parent.parent).resolve()
    with TemporaryDirectory() as folder:
        try_files(release, Path(folder))
        try_first_screen((release / "README.md").read_text(encoding="utf-8"), Path(folder))
        try_bag(Path(folder))
    print(f"lie_rigid_body {metadata.version('lie_rigid_body')} works with Python {sys.version.split()[0]}")


def try_files(release: Path, folder: Path) -> None:
    """The version is the release's, and what is no Python lies where it is looked for."""
    printed = "import lie_rigid_body as found; print(found.__version__, found.__path__[0])"
    version, _, package = run(sys.executable, "-c", printed, cwd=folder).strip().partition(" ")
    manifest = (release / "package.xml").read_text(encoding="utf-8")
    expect([version, metadata.version("lie_rigid_body")], 2 * re.findall("<version>(.+)</version>", manifest))
    if Path(package).resolve().is_relative_to(release):
        sys.exit(f"{package} is not installed, but a part of {release}")
    share = Path(sysconfig.get_path("data"), "share")
    of_release = [file.relative_to(release) for file in release.glob("config/**/*.*")]
    of_release += [file.relative_to(release) for file in release.glob("launch/*.launch.py")]
    wanted = [Path(package, "py.typed"), share / "ament_index/resource_index/packages/lie_rigid_body"]
    wanted += [share / "lie_rigid_body" / file for file in (*of_release, "package.xml")]
    wanted += [Path(package) / file for file in of_release if file.parts[0] == "config"]
    expect([str(file) for file in wanted if not file.is_file()], [])


def try_first_screen(readme: str, folder: Path) -> None:
    """The filter of the README gets the score that is shown, and `diagnose` names its mistake in the words shown."""
    [code], [score, said] = (re.findall(rf"^```{kind}\n(.*?)^```", readme, re.M | re.S) for kind in ("python", "text"))
    (folder / "my_filter.py").write_text(code, encoding="utf-8")
    printed = rows(run(sys.executable, "my_filter.py", cwd=folder))
    for name, numbers in rows(score).items():
        pairs = zip(map(float, printed.get(name, [])), map(float, numbers), strict=True)
        expect([pair for pair in pairs if abs(pair[0] - pair[1]) > ALIKE * abs(pair[1])], [])
    [command] = re.findall(r"^lie-rigid-body (.+)$", readme, re.M)
    diagnosed = run("lie-rigid-body", *shlex.split(command), cwd=folder, status=1).split()
    expect(diagnosed[: len(said.split())], said.split())


def rows(score: str) -> dict[str, list[str]]:
    """The five numbers of each line that ends with five, by what stands before them."""
    found = re.findall(r"^(\S.*?)((?: +\d\S*){5})$", score, re.M)
    return {name: numbers.split() for name, numbers in found}


def try_bag(folder: Path) -> None:
    """A bag is recorded, certified, explained and drawn."""
    run("lie-rigid-body", "record", "flips.mcap", "--scenario", "dzhanibekov", "--duration", "20", cwd=folder)
    run("lie-rigid-body", "check", "flips.mcap", cwd=folder)
    run("lie-rigid-body", "explain", "dzhanibekov", cwd=folder)
    run("lie-rigid-body", "plot", "flips.mcap", "-o", "flips.png", cwd=folder)
    expect((folder / "flips.png").read_bytes()[:4], b"\x89PNG")


def run(program: str, *arguments: str, cwd: Path, status: int = 0) -> str:
    """What a program of this environment prints, in a folder where no sources are."""
    path = shutil.which(program, path=sysconfig.get_path("scripts")) or program
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run(
        (path, *arguments), cwd=cwd, env={**kept, "PYTHONUTF8": "1"}, capture_output=True, encoding="utf-8", timeout=600
    )
    if done.returncode != status:
        sys.exit(f"{program} {shlex.join(arguments)} gave {done.returncode}\n{done.stdout}\n{done.stderr}")
    return done.stdout


def expect(found: object, wanted: object) -> None:
    """End the program if something is not as it should be."""
    if found != wanted:
        sys.exit(f"{found!r} instead of {wanted!r}")


if __name__ == "__main__":
    main()
