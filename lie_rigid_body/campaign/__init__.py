"""Campaigns: many runs of a scenario whose parameters are drawn at random, on this machine or a cluster.

- `definition`: what a campaign file says;
- `distributions`: the distributions that parameters are drawn from;
- `run`: one run, from its number to its bag, its certificate, its scores and its row;
- `results`: the rows that are finished, and the tables of all;
- `workers`: the processes that carry runs out, of this machine or of a Dask cluster;
- `comparison`: estimators over the runs.
"""

from lie_rigid_body.campaign.definition import Campaign

__all__ = ["Campaign"]
