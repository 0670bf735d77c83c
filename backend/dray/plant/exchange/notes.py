"""Findings about an imported layout: its oddities and its rejected data. Equal findings are counted as one."""

from __future__ import annotations

import msgspec

from dray.plant.file.reasons import Reason

MAX_NOTES = 500
"""Maximum number of different notes. A file with more of them is probably not in the format that it names."""


class Note(msgspec.Struct):
    """One finding, and how often it was made."""

    place: str
    """Its first place: a JSON pointer, or the line and element of an XML file."""
    text: Reason
    count: int = 1
    """Number of equal findings."""

    def line(self) -> str:
        """The finding as a line of text."""
        more = f" ({self.count} times; this is the first)" if self.count > 1 else ""
        return f"{self.place}: {self.text}{more}" if self.place else f"{self.text}{more}"


class Notes:
    """All findings, in the order of their first places."""

    def __init__(self) -> None:
        self._notes: dict[str, Note] = {}
        self._more = 0

    def add(self, place: str, text: Reason) -> None:
        """Add a finding about a place. A text that is known already is only counted."""
        known = self._notes.get(text)
        if known is not None:
            known.count += 1
        elif len(self._notes) < MAX_NOTES:
            self._notes[text] = Note(place, text)
        else:
            self._more += 1

    def all(self) -> tuple[Note, ...]:
        """All findings. The last one counts those beyond `MAX_NOTES`."""
        found = tuple(self._notes.values())
        return (*found, Note("", Reason("note_more", count=self._more))) if self._more else found
