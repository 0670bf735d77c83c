"""What an agent's operator can do with its process: a supervisor, a service manager, or the simulator."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Running:
    """How one agent is run.

    Attributes:
        starts_again: whether the agent is started again after it has left by itself.
        updates: whether it is then started with the newest installed software, if asked for.
    """

    starts_again: bool = False
    updates: bool = False


ALONE = Running()
"""An agent that is not started again."""
