"""Vehicles' own reports, remembered by a body that does not count, so that a repetition after a kill is booked once (`dray.body.Book`)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar

from dray.body import Book

BOOKED_KEPT = 256
"""Maximum reports remembered, the latest: many times the open transports of one place."""

Booked = TypeVar("Booked")


def name_of(book: Book) -> str:
    """The identity of a report: it is booked once under it, over all lives."""
    return f"{book.task} {book.epoch} {'in' if book.change > 0 else 'out'} {book.item}"


def with_word(booked: Mapping[str, Booked], book: Book, as_what: Booked) -> dict[str, Booked]:
    """The remembered reports with a new one; the oldest are dropped above the maximum.

    Args:
        booked: the bookings by name, the oldest first.
        book: a new report.
        as_what: its booking.
    """
    words = {**booked, name_of(book): as_what}
    return dict(list(words.items())[-BOOKED_KEPT:])
