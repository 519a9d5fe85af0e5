"""Arguments that name bags and their topics."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from lie_rigid_body.errors import InputError
from lie_rigid_body.wording import listed, shown, suggestion


def add_topic_argument(parser: argparse.ArgumentParser) -> None:
    """Add ``--topic``, which `topic_names` reads."""
    parser.add_argument(
        "--topic",
        metavar="NAME:=/TOPIC",
        action="append",
        default=[],
        dest="topics",
        help="what a topic of the body is called in the bag, such as pose:=/truth/pose; may be repeated",
    )


def topic_names(assignments: Sequence[str]) -> dict[str, str]:
    """The topics of ``--topic`` by their relative names.

    Raises
    ------
    InputError
        If one is no assignment, names no topic of a body, or one that was named before.
    """
    found: dict[str, str] = {}
    for text in assignments:
        name, _, topic = text.partition(":=")
        if not (name and topic):
            raise InputError(f"--topic {shown(text)}: not NAME:=/TOPIC; give for example --topic pose:=/truth/pose")
        from lie_rigid_body.recording.bodies import TYPES

        if name not in TYPES:
            raise InputError(f"--topic {text}: no topic {name!r}: {suggestion(name, list(TYPES), 'topics of a body')}")
        if found.setdefault(name, topic) != topic:
            raise InputError(f"--topic {text}: {name} is {found[name]} already: give {listed([name])} once")
    return found


def is_folder_of_bags(name: str) -> bool:
    """Whether an argument is a folder that is not one bag itself."""
    from lie_rigid_body.recording.bag_folders import is_one_bag

    return Path(name).is_dir() and not is_one_bag(Path(name))


def bags_of(names: Sequence[str]) -> list[str]:
    """The bags that the arguments name, folders of bags searched, each bag once."""
    from lie_rigid_body.recording.bag_folders import bags_in

    found: dict[Path, str] = {}
    for name in names:
        for bag in bags_in(Path(name)) if is_folder_of_bags(name) else [name]:
            found.setdefault(Path(bag).resolve(), str(bag))
    return list(found.values())
