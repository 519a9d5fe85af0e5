"""``lie-rigid-body campaign``: many runs of a scenario with parameters drawn at random."""

from __future__ import annotations

import argparse
from importlib.util import find_spec

from lie_rigid_body.command_line import FORCE, WORKERS, argument, file_name, verb
from lie_rigid_body.foundation.errors import InputError


@verb(
    "Record and certify many runs with parameters drawn at random.",
    argument("campaign", metavar="CAMPAIGN.yaml", type=file_name, help="what varies, and how many runs there are"),
    argument(
        "--out",
        metavar="DIR",
        type=file_name,
        required=True,
        help="folder of the table and the bags; resumed if begun",
    ),
    argument("--no-bags", action="store_true", help="keep the table only"),
    argument(
        "--report",
        metavar="OUT.html",
        type=file_name,
        help="write the estimators, or the runs, as one page",
    ),
    FORCE,
    either=(
        WORKERS,
        argument("--scheduler", metavar="ADDRESS", help="scheduler of a Dask cluster of yours, as tcp://host:8786"),
    ),
)
def main(given: argparse.Namespace) -> int:
    """Run the verb with the given arguments, or those of the process, and return the exit status."""
    name, extra = ("distributed", "cluster") if given.scheduler else ("pyarrow", "campaign")
    if not find_spec(name):
        raise InputError(f"campaign needs {name}: pip install 'lie-rigid-body[{extra}]'")

    from lie_rigid_body.cli.campaign_runs import run_campaign

    return run_campaign(given)
