"""Results that are kept in a file, so that a run of an hour that was interrupted goes on where it was."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from hashlib import sha256
from importlib.metadata import version
from inspect import getsource
from pathlib import Path
from sys import modules
from typing import Any, Final, TypeVar

from tqdm import tqdm

from league.contender import Filter, Setting

T = TypeVar("T")
KEPT: Final = Path(__file__).resolve().parents[2] / ".cache" / "league.jsonl"


def key_of(contender: Filter, setting: Setting, digest: str) -> str:
    """What a result depends on, as 20 hexadecimal digits, with the hash of its readings."""
    source = getsource(modules[contender.estimate.__module__])
    parts = (contender.full_name, version(contender.library), source, json.dumps(dict(setting)), digest)
    return sha256("\n".join(parts).encode()).hexdigest()[:20]


def each(
    pool: Executor, function: Callable[[T], Any], jobs: Sequence[T], keys: Sequence[str], name: str, path: Path = KEPT
) -> list[Any]:
    """Results of a function of jobs, JSON-serialisable data, in their order; those that are kept are not made again."""
    path.parent.mkdir(exist_ok=True)
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    kept = {line["key"]: line["result"] for line in map(json.loads, lines)}
    new = {key: job for key, job in zip(keys, jobs, strict=True) if key not in kept}
    results = pool.map(function, new.values())
    with path.open("a", encoding="utf-8") as stream:
        for key, result in tqdm(zip(new, results, strict=True), desc=name, total=len(new), disable=None):
            kept[key] = result
            stream.write(f"{json.dumps({'key': key, 'result': result})}\n")
            stream.flush()
    return [kept[key] for key in keys]
