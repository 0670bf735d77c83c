"""The master's events and effects, and its memory for the next life."""

from __future__ import annotations

from typing import Any, Literal

from dray.body import Report, VehicleInstruction
from dray.messages.base import Part


class OrderMemory(Part, frozen=True):
    """The last sent order, for the next life."""

    id: str
    update: int
    number: int
    """The number of the agent's instruction."""
    kind: str
    nodes: tuple[str, ...]
    """The nodes of its base; sequence numbers are even and begin at 0."""
    is_shown: bool
    """Whether the vehicle's state has shown it."""
    action: str = ""
    """The id of its action; empty for a step."""
    station: str = ""
    item: str = ""
    quantity: int = 0
    goal: str = ""


class Memory(Part, frozen=True):
    """A master's memory for the next life."""

    load: str = ""
    quantity: int = 0
    order: OrderMemory | None = None
    """The present order, until it is over."""
    doubt: str = ""
    """Why the load on board is unknown; empty when it is known."""


DAMAGED = Memory(
    doubt="what was remembered is damaged: see what is on board, and switch it to MANUAL and back"
)
"""The memory after unreadable data."""


class Instructed(Part, frozen=True):
    """An instruction of its agent."""

    instruction: VehicleInstruction


class Heard(Part, frozen=True):
    """A message of the vehicle."""

    topic: str
    """The last chunk: state, visualization, connection, factsheet."""
    data: bytes


class Woke(Part, frozen=True):
    """Time has passed."""


class Cancel(Part, frozen=True):
    """A commissioning cancels the present order; the rest of a way continues from the present position."""


class Linked(Part, frozen=True):
    """The broker is connected, and the vehicle's topics are subscribed to."""


class Unlinked(Part, frozen=True):
    """The connection to the broker is lost."""

    reason: str


Event = Instructed | Heard | Woke | Linked | Unlinked | Cancel


def kind_of(event: Event) -> str:
    """The topic of a message, the name of any other event."""
    return event.topic if isinstance(event, Heard) else type(event).__name__


class Say(Part, frozen=True):
    """Publish this under the vehicle's topics. The shell adds the header."""

    topic: Literal["order", "instantActions"]
    body: dict[str, Any]


class Tell(Part, frozen=True):
    """Report this to the agent."""

    report: Report


class Remember(Part, frozen=True):
    """Store this before any later effect is sent."""

    memory: Memory


class Note(Part, frozen=True):
    """A text for people in the log."""

    text: str


Effect = Say | Tell | Remember | Note
