"""Arguments that name bags."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path


def is_folder_of_bags(name: str) -> bool:
    """Whether an argument is a folder that is not one bag itself."""
    from lie_rigid_body.recording.bag_files import is_one_bag

    return Path(name).is_dir() and not is_one_bag(Path(name))


def bags_of(names: Sequence[str]) -> list[str]:
    """The bags that the arguments name, folders of bags searched, each bag once."""
    from lie_rigid_body.recording.bag_folders import bags_in

    found: dict[Path, str] = {}
    for name in names:
        for bag in bags_in(Path(name)) if is_folder_of_bags(name) else [name]:
            found.setdefault(Path(bag).resolve(), str(bag))
    return list(found.values())
