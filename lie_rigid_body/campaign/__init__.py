"""Campaigns: many runs of a scenario whose parameters are drawn at random, on the workers of a Dask cluster.

- `definition`: what a campaign file says;
- `distributions`: the distributions that parameters are drawn from;
- `run`: one run, from its number to its bag, its certificate and its row;
- `estimator`: the scores of an estimator in a run;
- `journal`: the rows that are finished, and the table of all;
- `cluster`: the runs on the workers of a Dask cluster.
"""

from lie_rigid_body.campaign.definition import Campaign

__all__ = ["Campaign"]
