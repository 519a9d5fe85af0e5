"""Recovering a rosbag2 folder with a file that was cut off, into a new folder that is whole."""

from __future__ import annotations

import shutil
from pathlib import Path

from lie_rigid_body.errors import BagError
from lie_rigid_body.recording.bag_files import is_one_bag, natural_order
from lie_rigid_body.recording.output_file import reason
from lie_rigid_body.recording.recovery import NothingWholeError, Recovery, recover


def recover_folder(broken: Path, fixed: Path) -> dict[Path, Recovery | NothingWholeError]:
    """Write every whole message of the MCAP files of a folder into those of a new one, file by file.

    Its files are named after the new folder, as those of rosbag2 are; metadata.yaml is left to ``ros2 bag reindex``.

    Parameters
    ----------
    broken : Path
        It is only read, and its metadata not even that.
    fixed : Path
        Must not exist.

    Returns
    -------
    dict of Path to Recovery or NothingWholeError
        What was recovered of each file, in their order, or why nothing was, as of one that was just begun.

    Raises
    ------
    BagError
        If the folder is none of one bag or has no whole message, or the new one cannot be written.
    """
    files = sorted(broken.glob("*.mcap"), key=natural_order)
    if not files:
        raise BagError(f"{broken} is a folder without MCAP files: give a bag")
    if not is_one_bag(broken):
        raise BagError(f"{broken} is not the folder of one bag: recover the MCAP files in it one by one")
    _make(broken, fixed)
    found = dict[Path, Recovery | NothingWholeError]()
    try:
        whole = 0
        for file in files:
            found[file] = _recovered(file, fixed / f"{fixed.resolve().name}_{whole}.mcap")
            whole += isinstance(found[file], Recovery)
        if not whole:
            raise BagError(f"{broken} holds no whole message: record it again")
    except BaseException:
        shutil.rmtree(fixed, ignore_errors=True)
        raise
    return found


def _make(broken: Path, fixed: Path) -> None:
    if fixed.suffix.lower() == ".mcap":
        raise BagError(f"{broken} is a folder, and {fixed} is to be one: give a name that does not end in .mcap")
    if broken.resolve() in fixed.resolve().parents:
        raise BagError(f"{fixed} is in the broken folder itself, which is never touched: give another place")
    try:
        fixed.mkdir()
    except FileExistsError:
        raise BagError(f"{fixed} exists and is kept: give the name of a new folder") from None
    except OSError as error:
        raise BagError(f"{fixed} cannot be created: {reason(error)}: give a place where you may write") from None


def _recovered(file: Path, into: Path) -> Recovery | NothingWholeError:
    try:
        return recover(file, into, overwrite=False)
    except NothingWholeError as error:
        return error
