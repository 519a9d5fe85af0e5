"""The league: attitude filters over the same cases, each with its row in one table, which anybody's filter can join."""

from lie_rigid_body.league.cases import CASES, Case
from lie_rigid_body.league.table import EDITION, FilterRow, LeagueTable, reference, standing

__all__ = ["CASES", "EDITION", "Case", "FilterRow", "LeagueTable", "reference", "standing"]
