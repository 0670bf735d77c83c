"""People as a body: their reports of events, and the answers."""

from __future__ import annotations

from dray.messages.base import Part
from dray.messages.people.command import MachineCommandKind
from dray.messages.reason import CommandRefusal


class Word(Part, frozen=True):
    """A person's report of an event, for a body operated by people. `WordTaken` answers it, each time that it is sent."""

    key: str
    """A permanent name: a repetition under the same key is not counted again."""
    kind: MachineCommandKind
    """One of `WORDS`."""
    item: str
    """The item; empty for the product in work."""
    quantity: int
    vehicle: str = ""
    sure: bool = False
    """The number is confirmed, however far it is from the expected one."""


class WordTaken(Part, frozen=True):
    """The answer to a `Word`. An accepted one is on the disk."""

    key: str
    refused: CommandRefusal | None = None
    detail: str = ""
    """The expected number, where that is the reason."""
    again: bool = False
    """It is a repetition."""
