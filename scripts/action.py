"""The GitHub Action: a verb on a filter, its table in the summary of the job, with the difference to the base branch.

    python scripts/action.py VERB ANSWER.json BASE.json ARGUMENTS

ARGUMENTS is one word, which is split as a shell does. The exit status is that of the verb. BASE.json is the answer of
the base branch; empty, or not there: none.
"""

from __future__ import annotations

import json
import os
import shlex
import subprocess
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any


def main(verb: str, answer: str, base: str, arguments: str) -> int:
    """Run the verb, write the summary, and return the exit status."""
    status, said, complained = run(verb, answer, arguments)
    print(said, end="")
    print(complained, end="", file=sys.stderr)
    found = numbers(verb, Path(answer)) if status in (0, 1) else None
    outcome = "no answer" if found is None else ("passed", "failed")[status]
    lines = [f"### `{verb} {arguments}`: {outcome}", ""]
    if found is not None:
        before = numbers(verb, Path(base)) if base and Path(base).is_file() else {}
        if before is None:
            lines += [f"Base not readable: `{base}` is no answer of `{verb}`.", ""]
        lines += [*table(found, before or {}), ""]
    lines += folded("All that it says", said) if found is not None else ["```text", complained.rstrip(), "```"]
    summary = os.environ.get("GITHUB_STEP_SUMMARY")
    if summary:
        with open(summary, "a", encoding="utf-8") as file:
            file.write("\n".join([*lines, ""]))
    return status


def run(verb: str, answer: str, arguments: str) -> tuple[int, str, str]:
    """Exit status of the verb, as a shell has it, and what it printed on both streams."""
    try:
        words = shlex.split(arguments)
    except ValueError as error:
        return 2, "", f"arguments: {error}: quote them as on a command line\n"
    with suppress(OSError):  # the answer of an earlier step is none of this one
        Path(answer).unlink()
    command = [sys.executable, "-m", "lie_rigid_body", verb, *words, "--json", answer, "--force"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode < 0:
        return 128 - done.returncode, done.stdout, f"{done.stderr}{verb} was killed by signal {-done.returncode}\n"
    return done.returncode, done.stdout, done.stderr


def folded(title: str, text: str) -> list[str]:
    """Text that is shown when its title is clicked."""
    return [f"<details><summary>{title}</summary>", "", "```text", text.rstrip(), "```", "", "</details>"]


def numbers(verb: str, answer: Path) -> dict[str, object] | None:
    """What is compared of an answer, by its name; None where the file is no answer of the verb."""
    try:
        content = json.loads(answer.read_text(encoding="utf-8"))
        return dict({"evaluate": of_scores, "diagnose": of_diagnosis, "league": of_rows}[verb](content))
    except (OSError, ValueError, LookupError, TypeError, AttributeError):
        return None


def of_scores(content: Any) -> Iterator[tuple[str, object]]:
    """Errors of each estimate, deg, and what is found."""
    for score in content.get("estimates", [content]):
        name = f"{score['topic']}: " if "estimates" in content and "topic" in score else ""
        for kind in ("total", "heading", "inclination"):
            yield f"{name}{kind} error, RMS (deg)", score[f"{kind}_deg"]["rms"]
        yield f"{name}found", ", ".join(finding["code"] for finding in score["findings"]) or "nothing"


def of_diagnosis(content: Any) -> Iterator[tuple[str, object]]:
    """Mistakes, and the verdict on each probe."""
    yield "mistakes", ", ".join(mistake["code"] for mistake in content["mistakes"]) or "none"
    words = {True: "passed", False: "failed", None: "not judged"}
    for probe in content["probes"]:
        yield f"probe {probe['code']}", words[probe["passed"]]


def of_rows(content: Any) -> Iterator[tuple[str, object]]:
    """Error of the filter overall, deg, and its rank."""
    for row in content["rows"]:
        yield f"{row['name']}: overall (deg)", row["overall"]
        yield f"{row['name']}: rank", row["rank"]


def table(found: dict[str, object], before: dict[str, object]) -> list[str]:
    """Table in Markdown of what was found, beside what the base branch has, with the difference of numbers."""
    rows = [f"| {name} | {shown(value)} |" for name, value in found.items()]
    if not before:
        return ["| | here |", "| --- | --- |", *rows]
    rows = [
        f"{row} {shown(before.get(name, ''))} | {change(found[name], before.get(name))} |"
        for name, row in zip(found, rows, strict=True)
    ]
    gone = [f"| {name} | | {shown(value)} | gone |" for name, value in before.items() if name not in found]
    return ["| | here | base | change |", "| --- | --- | --- | --- |", *rows, *gone]


def shown(value: object) -> str:
    """A value with four digits of a number."""
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def change(now: object, before: object) -> str:
    """The difference of two numbers; of other values whether they differ."""
    if isinstance(now, int | float) and isinstance(before, int | float):
        return f"{now - before:+.3g}" if now != before else ""
    return "" if now == before else "changed"


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
