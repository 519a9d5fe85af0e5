"""A campaign as one HTML page."""

from __future__ import annotations

from collections.abc import Sequence

from lie_rigid_body.campaign import Campaign
from lie_rigid_body.campaign.run import Row
from lie_rigid_body.cli import overview_page
from lie_rigid_body.parameters import Value
from lie_rigid_body.report import html_page


def page(title: str, campaign: Campaign, rows: Sequence[Row]) -> bytes:
    """The page.

    Parameters
    ----------
    title : str
    campaign : Campaign
    rows : sequence of Row
        At least one, in the order of the table.

    Returns
    -------
    bytes
        HTML.
    """
    lines = [
        overview_page.Line(
            (str(row.run), *(_shown(row.parameters[name]) for name in campaign.vary)),
            row.certified,
            row.attitude_accuracy_rad,
            row.residuals,
        )
        for row in rows
    ]
    declared = html_page.details("Campaign", campaign.to_json())
    return overview_page.page(title, "runs", ("run", *campaign.vary), lines, [declared])


def _shown(value: Value | Sequence[float]) -> str:
    if isinstance(value, float):
        return f"{value:.4g}"
    return str(value) if isinstance(value, str | int) else f"[{', '.join(f'{v:.4g}' for v in value)}]"
