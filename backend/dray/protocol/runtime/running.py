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


def life_mark(incarnation: int) -> str:
    """What marks the names that an agent gives in one life, so that no two lives give the same; nothing in the first one."""
    return "" if incarnation == 1 else f".{incarnation}"
