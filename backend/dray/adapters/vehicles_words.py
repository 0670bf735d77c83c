"""Words of vehicles that a body which does not count remembers, so that one that is said again after a kill is booked once (`dray.body.Book`)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar

from dray.body import Book

BOOKED_KEPT = 256
"""Words that are remembered, the latest: many times the transports that one place has open."""

Booked = TypeVar("Booked")


def name_of(book: Book) -> str:
    """What names a word: it is booked once under it, by whichever life."""
    return f"{book.task} {book.epoch} {'in' if book.change > 0 else 'out'} {book.item}"


def with_word(booked: Mapping[str, Booked], book: Book, as_what: Booked) -> dict[str, Booked]:
    """The words that are remembered with one more, and without the oldest where they are too many.

    Args:
        booked: by name, what each was booked as; the oldest first.
        book: a word that is not among them.
        as_what: what it was booked as.
    """
    words = {**booked, name_of(book): as_what}
    return dict(list(words.items())[-BOOKED_KEPT:])
