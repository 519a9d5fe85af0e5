"""The GitHub Action: a verb on a filter, its table in the summary of the job, with the difference to the base branch.

    python scripts/action.py VERB ANSWER.json BASE.json ARGUMENTS...

The exit status is that of the verb. BASE.json is the answer of the base branch; empty, or not there: none.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any


def main(verb: str, answer: str, base: str, *arguments: str) -> int:
    """Run the verb, write the summary, and return the exit status."""
    command = [sys.executable, "-m", "lie_rigid_body", verb, *arguments, "--json", answer, "--force"]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=False)
    print(done.stdout, end="")
    lines = [f"### `{verb} {' '.join(arguments)}`: {('passed', 'failed', 'no answer')[min(done.returncode, 2)]}", ""]
    if done.returncode in (0, 1):
        lines += table(numbers(verb, Path(answer)), numbers(verb, Path(base)) if base and Path(base).is_file() else {})
        lines += [
            "",
            "<details><summary>All that it says</summary>",
            "",
            "```text",
            done.stdout.rstrip(),
            "```",
            "",
            "</details>",
        ]
    summary = os.environ.get("GITHUB_STEP_SUMMARY")
    if summary:
        with open(summary, "a", encoding="utf-8") as file:
            file.write("\n".join([*lines, ""]))
    return done.returncode


def numbers(verb: str, answer: Path) -> dict[str, object]:
    """What is compared of an answer, by its name."""
    content = json.loads(answer.read_text(encoding="utf-8"))
    return dict({"evaluate": of_scores, "diagnose": of_diagnosis, "league": of_rows}[verb](content))


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
