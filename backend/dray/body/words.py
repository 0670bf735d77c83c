"""People as a body: their words, and what became of them."""

from __future__ import annotations

from dray.messages.base import Part
from dray.messages.people.command import MachineCommandKind
from dray.messages.reason import CommandRefusal


class Word(Part, frozen=True):
    """What a person says has happened; only for a body that is people. It is answered with `WordTaken`, each time that it is said."""

    key: str
    """Names the word for ever: one that is said again under its key is not counted again."""
    kind: MachineCommandKind
    """One of `WORDS`."""
    item: str
    """Empty for the product that is being made."""
    quantity: int
    vehicle: str = ""
    sure: bool = False
    """The number is right, however far it is from the expected one."""


class WordTaken(Part, frozen=True):
    """What became of a `Word`. One that was not refused is on the disk."""

    key: str
    refused: CommandRefusal | None = None
    detail: str = ""
    """The number that was expected, where that is why."""
    again: bool = False
    """It was said before."""
