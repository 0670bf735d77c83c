"""The book: what strikes a line out, and what does not."""

from __future__ import annotations

import pytest

from dray.errors import ProtocolViolation
from dray.messages.floor.traffic import PlaceWished
from dray.protocol.traffic.books.book import Book


def wish(*holds: str, seen: int = 0, life: int = 1) -> PlaceWished:
    return PlaceWished(
        district="M4",
        life=life,
        seq=1,
        epoch=0,
        rank=(0, 0.0, "A"),
        holds=holds,
        groups=(),
        seen=seen,
        stands=True,
        docked=False,
    )


def test_a_grant_is_struck_out_on_a_word_said_after_it_was_seen() -> None:
    book = Book()
    book.grant("A", ["b3"])
    assert book.strike(wish(seen=1), "A")
    assert book.holder("b3") == ""


def test_a_word_that_was_said_before_the_grant_was_seen_changes_nothing() -> None:
    book = Book()
    book.grant("A", ["b3"])
    assert not book.strike(wish(seen=0), "A")
    assert book.holder("b3") == "A"


def test_an_old_word_does_not_strike_out_a_new_grant_of_the_same_place() -> None:
    book = Book()
    book.grant("A", ["b3"])
    old = wish(seen=1)
    book.strike(old, "A")
    book.grant("A", ["b3"])
    assert not book.strike(old, "A")


def test_nobody_strikes_out_what_another_one_holds() -> None:
    book = Book()
    book.grant("A", ["b3"])
    assert not book.strike(wish(seen=10**9), "B")
    assert book.holder("b3") == "A"


def test_a_new_life_is_granted_anew_what_it_has_not_seen() -> None:
    book = Book()
    book.begin_life("A", wish())
    book.grant("A", ["b3", "c3"])
    assert book.begin_life("A", wish("b3", life=2))
    assert {line.number for line in book.of("A")} == {2}
    assert not book.begin_life("A", wish("b3", life=2))


def test_a_place_is_never_written_down_for_two() -> None:
    book = Book()
    book.grant("A", ["b3"])
    with pytest.raises(ProtocolViolation, match="b3 is held by A"):
        book.grant("B", ["b3"])


def test_a_carried_away_vehicle_holds_nothing() -> None:
    book = Book()
    book.grant("A", ["b3"])
    assert book.remove("A", 1) == ("b3",)
    book.grant("A", ["b3"])
    assert book.remove("A", 1) == ()
    assert book.holder("b3") == "A", "an old word frees nothing that was granted since"
