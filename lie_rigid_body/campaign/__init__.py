"""Campaigns: many runs of a scenario whose parameters are drawn at random, on the workers of a Dask cluster.

- `definition`: what a campaign file says;
- `distributions`: the distributions that parameters are drawn from;
- `run`: one run, from its number to its bag, its certificate, its scores and its row;
- `journal`: the rows that are finished, and the table of all;
- `cluster`: the runs on the workers of a Dask cluster.
"""

from lie_rigid_body.campaign.definition import Campaign

__all__ = ["Campaign"]
