"""What can be done with an agent's process by whoever runs it: a supervisor, a service manager, the simulator."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Running:
    """How one agent is run.

    Attributes:
        starts_again: it is started again when it has left by itself.
        updates: and then, if asked for that, with the newest software that lies ready.
    """

    starts_again: bool = False
    updates: bool = False


ALONE = Running()
"""Nobody starts it again."""
