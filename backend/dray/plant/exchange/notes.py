"""Oddities of a layout, and rejected data: each with its place, equal ones together."""

from __future__ import annotations

import msgspec

from dray.plant.file.reasons import Reason

MAX_NOTES = 500
"""Most different notes that are spelt out; a file with more has another format than it claims."""


class Note(msgspec.Struct):
    """One finding."""

    place: str
    """The first place: a JSON pointer, or the line and element of an XML file."""
    text: Reason
    count: int = 1
    """Number of equal findings."""

    def line(self) -> str:
        """A line for people."""
        more = f" ({self.count} times; this is the first)" if self.count > 1 else ""
        return f"{self.place}: {self.text}{more}" if self.place else f"{self.text}{more}"


class Notes:
    """Findings in the order in which they were made first."""

    def __init__(self) -> None:
        self._notes: dict[str, Note] = {}
        self._more = 0

    def add(self, place: str, text: Reason) -> None:
        """Say something of a place; the same text of another place is counted only."""
        known = self._notes.get(text)
        if known is not None:
            known.count += 1
        elif len(self._notes) < MAX_NOTES:
            self._notes[text] = Note(place, text)
        else:
            self._more += 1

    def all(self) -> tuple[Note, ...]:
        """Everything that was said."""
        found = tuple(self._notes.values())
        return (*found, Note("", Reason("note_more", count=self._more))) if self._more else found
