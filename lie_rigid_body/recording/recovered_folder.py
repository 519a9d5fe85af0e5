"""Recovering a bag in a folder, file by file, into a new folder."""

from __future__ import annotations

import shutil
from pathlib import Path

from lie_rigid_body.foundation.errors import BagError
from lie_rigid_body.foundation.wording import program
from lie_rigid_body.recording.bag_files import recording_files
from lie_rigid_body.recording.recovery import NothingWholeError, Recovery, recover
from lie_rigid_body.system.output_file import reason
from lie_rigid_body.system.portable import real_path


def recover_folder(broken: Path, fixed: Path) -> dict[Path, Recovery | NothingWholeError]:
    """Write every whole message of the files of a bag in a folder into those of a new one, file by file.

    They are named after the new folder, as those of rosbag2 are; metadata.yaml is left to ``ros2 bag reindex``.

    Parameters
    ----------
    broken : Path
        It is only read. Where it has a metadata.yaml, that says which files are the bag's.
    fixed : Path
        Must not exist.

    Returns
    -------
    dict of Path to Recovery or NothingWholeError
        What was recovered of each file, in their order, or why nothing was, as of one that was just begun, or is gone.

    Raises
    ------
    BagError
        If the folder is none of one bag, nothing is whole, or the new one cannot be written.
    """
    files = recording_files(broken)
    _make(broken, fixed)
    found = dict[Path, Recovery | NothingWholeError]()
    whole = 0
    try:
        for file in files:
            try:
                found[file] = recover(file, fixed / f"{real_path(fixed).name}_{whole}.mcap", overwrite=False)
                whole += 1
            except NothingWholeError as error:
                found[file] = error
        if not whole:
            raise BagError(f"{broken} holds nothing that can be recovered: '{program('check')}' says why")
    except BaseException:
        shutil.rmtree(fixed, ignore_errors=True)
        raise
    return found


def _make(broken: Path, fixed: Path) -> None:
    if fixed.suffix.lower() == ".mcap":
        raise BagError(f"{broken} is a folder, and {fixed} is to be one: give a name that does not end in .mcap")
    if real_path(broken) in real_path(fixed).parents:
        raise BagError(f"{fixed} is in the broken folder itself, which is never touched: give another place")
    try:
        fixed.mkdir()
    except FileExistsError:
        raise BagError(f"{fixed} exists and is kept: give the name of a new folder") from None
    except OSError as error:
        raise BagError(f"{fixed} cannot be created: {reason(error)}: give a place where you may write") from None
