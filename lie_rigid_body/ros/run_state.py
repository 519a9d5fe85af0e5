"""What time does in a run."""

from __future__ import annotations

from enum import Enum


class RunState(Enum):
    """What time does."""

    STOPPED = "stopped"
    """It stands still at the start of a motion."""
    PLAYING = "playing"
    PAUSED = "paused"
