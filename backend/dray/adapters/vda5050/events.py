"""What the master is told and what it wants done: its events and effects, and what it leaves to its next life."""

from __future__ import annotations

from typing import Any, Literal

from dray.body import Report, VehicleInstruction
from dray.messages.base import Part


class OrderMemory(Part, frozen=True):
    """The order that was said last, as the next life must know it."""

    id: str
    update: int
    number: int
    """Of the agent's instruction."""
    kind: str
    nodes: tuple[str, ...]
    """Of its base; sequence numbers are even and begin at 0."""
    is_shown: bool
    """The vehicle's state has shown it."""
    action: str = ""
    """The id of its action; empty for a step."""
    station: str = ""
    item: str = ""
    quantity: int = 0
    goal: str = ""


class Memory(Part, frozen=True):
    """What the next life must know."""

    load: str = ""
    quantity: int = 0
    order: OrderMemory | None = None
    """Until it is over."""
    doubt: str = ""
    """Why it is not known what is on board; empty when it is."""


DAMAGED = Memory(
    doubt="what was remembered is damaged: see what is on board, and switch it to MANUAL and back"
)
"""What is known where a life has left something that cannot be read."""


class Instructed(Part, frozen=True):
    """Its agent wants something done."""

    instruction: VehicleInstruction


class Heard(Part, frozen=True):
    """The vehicle has said something."""

    topic: str
    """The last chunk: state, visualization, connection, factsheet."""
    data: bytes


class Woke(Part, frozen=True):
    """Time has passed."""


class Cancel(Part, frozen=True):
    """Whoever commissions the vehicle wants its present order cancelled; what is left of a way goes on from where it stands."""


class Linked(Part, frozen=True):
    """The broker is there, and what the vehicle says is subscribed to."""


class Unlinked(Part, frozen=True):
    """The broker is away."""

    reason: str


Event = Instructed | Heard | Woke | Linked | Unlinked | Cancel


def kind_of(event: Event) -> str:
    """The topic of a message, the name of any other event."""
    return event.topic if isinstance(event, Heard) else type(event).__name__


class Say(Part, frozen=True):
    """Publish this under the vehicle's topics. The shell puts the header before it."""

    topic: Literal["order", "instantActions"]
    body: dict[str, Any]


class Tell(Part, frozen=True):
    """Report this to the agent."""

    report: Report


class Remember(Part, frozen=True):
    """Write this down before anything that follows is said."""

    memory: Memory


class Note(Part, frozen=True):
    """Something that people should read in the log."""

    text: str


Effect = Say | Tell | Remember | Note
