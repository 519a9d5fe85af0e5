"""What the verbs say of an output that is an input itself, by whichever name, with ``--force`` too."""
# mypy: ignore-errors

from __future__ import annotations

import os
import shutil
from pathlib import Path
from unittest.mock import patch

from lie_rigid_body.__main__ import main
from lie_rigid_body.scenario import parameter_file

METADATA = "rosbag2_bagfile_information: {relative_file_paths: [run_0.mcap, named]}"
PROGRAM = "#!/bin/sh\nexec awk -F, 'NR > 1 {print $1 \",0,0,0,1\"}'\n"
FILES = {
    "given.yaml": "/**: {ros__parameters: {rate: 50.0}}",
    "other.yaml": "/**: {ros__parameters: {rate: 50.0}}",
    "campaign.html": "{runs: 1, seed: 1, duration: 0.1}",
    "of_program.yaml": "{runs: 1, seed: 1, duration: 0.1, estimators: {mine: {command: ./program.html}}}",
    "program.html": PROGRAM,
    "bags/run/metadata.yaml": METADATA,
}
HARD = {"bag.html": "bag.mcap", "bag.png": "bag.mcap", "link.yaml": "given.yaml"}
SOFT = {"s.html": "bag.mcap", "s.png": "bag.mcap", "run.png": "bags/run/run_0.mcap", "named.html": "bags/run/named"}


def prepare(folder):
    """Where ``bag.html`` and ``bag.png`` are the bag itself, and ``link.yaml`` is the parameter file."""
    assert main(["record", "bag.mcap", "--duration", "0.1", "--quiet"]) == 0
    Path("bags/run").mkdir(parents=True)
    for copy in ("other.mcap", "bags/run/run_0.mcap", "bags/run/named"):
        shutil.copy("bag.mcap", copy)
    for name, text in FILES.items():
        Path(name).write_text(text)
    Path("program.html").chmod(0o755)
    for name, target in HARD.items():
        os.link(target, name)
    for name, target in SOFT.items():
        Path(name).symlink_to(target)


def run(words):
    with patch.object(parameter_file, "CONFIG", Path.cwd()):
        return main(words)
