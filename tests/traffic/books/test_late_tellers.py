"""Vehicles that tell what they hold after a roll call: each key once, and a stranger only where it is heard to be."""

from __future__ import annotations

import msgspec
import pytest
from book_keeper import HERE, PLACES, beat, wish

from dray.messages.base import COUNT_MAX
from dray.protocol.traffic.books.book import Book
from dray.protocol.traffic.books.late_tellers import LateTellers
from dray.protocol.traffic.books.reach import Reach
from dray.protocol.traffic.neighbours import Neighbours
from dray.protocol.traffic.numbers import FAR, VERSION_LEAP

STRANGER = "ATV77"


@pytest.fixture
def neighbours() -> Neighbours:
    return Neighbours()


@pytest.fixture
def late(neighbours: Neighbours) -> LateTellers:
    """After a roll call in which ATV1 alone has told."""
    late = LateTellers(Reach(PLACES, neighbours, ("ATV1",)))
    late.start([("ATV1", b"")])
    return late


def test_who_has_told_in_the_roll_call_tells_nothing_more(late: LateTellers) -> None:
    book = Book()
    assert late.on_wish("ATV1", wish(HERE), book, 0.0)
    assert book.bookings == ()


def test_a_stranger_counts_when_it_is_heard_where_it_says_that_it_is(
    late: LateTellers, neighbours: Neighbours
) -> None:
    book = Book()
    assert not late.on_wish(STRANGER, wish(HERE), book, 0.0)
    assert late.unknown == {STRANGER}
    neighbours.on_vehicle(beat(atv=STRANGER), 1.0)
    assert late.on_wish(STRANGER, wish(HERE), book, 1.0)
    assert book.holder(HERE) == STRANGER
    assert late.unknown == set()


def test_who_says_to_have_seen_what_is_beyond_all_numbers_does_not_move_the_books(late: LateTellers) -> None:
    """Another key speaks in the name of one that has told, and holds where that one may be."""
    book = Book()
    forged = msgspec.structs.replace(wish(HERE), key=b"k" * 32, seen=COUNT_MAX)
    assert not late.on_wish("ATV1", forged, book, 0.0)
    assert (book.version, book.bookings) == (0, ())


def test_one_that_says_to_have_seen_the_last_version_that_is_believed_leaves_room_above(
    late: LateTellers,
) -> None:
    book = Book(version=7)
    forged = msgspec.structs.replace(wish(HERE), key=b"k" * 32, seen=FAR)
    assert late.on_wish("ATV1", forged, book, 0.0)
    assert FAR // 2 <= book.version < FAR // 2 + VERSION_LEAP


def test_a_book_that_was_not_made_from_a_roll_call_knows_what_is_held(late: LateTellers) -> None:
    late.start(None)
    book = Book()
    assert late.on_wish(STRANGER, wish(HERE), book, 0.0)
    assert book.holder(HERE) == ""
