"""The table: what strikes a line out, and what does not."""

from __future__ import annotations

from typing import Any

import pytest
from msgspec.structs import replace

from dray.errors import ProtocolViolation
from dray.messages.floor.traffic import PlaceRequested
from dray.protocol.traffic.reservations.reservation_table import ReservationTable


def request(*holds: str, seen: int = 0, life: int = 1) -> PlaceRequested:
    return PlaceRequested(
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
    table = ReservationTable()
    table.grant("A", ["b3"])
    assert table.strike(request(seen=1), "A")
    assert table.holder("b3") == ""


def test_a_word_that_was_said_before_the_grant_was_seen_changes_nothing() -> None:
    table = ReservationTable()
    table.grant("A", ["b3"])
    assert not table.strike(request(seen=0), "A")
    assert table.holder("b3") == "A"


def test_an_old_word_does_not_strike_out_a_new_grant_of_the_same_place() -> None:
    table = ReservationTable()
    table.grant("A", ["b3"])
    old = request(seen=1)
    table.strike(old, "A")
    table.grant("A", ["b3"])
    assert not table.strike(old, "A")


def test_a_place_where_its_vehicle_has_come_to_stand_again_is_granted_anew_once() -> None:
    table = ReservationTable()
    table.grant("A", ["b3"])
    table.grant("A", ["b4"])
    release = request("b4", seen=2)
    asked = replace(request(), groups=(("b3",),), renews=2)
    table.renew("A", asked)
    table.renew("A", asked)
    assert {line.place: line.number for line in table.of("A")} == {"b3": 3, "b4": 2}
    assert not table.strike(release, "A")
    assert table.strike(request("b4", seen=3), "A") == 1, "a copy may have the line under its first number"


def test_no_request_renews_what_another_one_holds() -> None:
    table = ReservationTable()
    table.grant("A", ["b3"], b"A")
    for sender, mark in (("B", b"B"), ("A", b"thief")):
        table.renew(sender, replace(request(), groups=(("b3",),), renews=10**6, key=mark))
    assert [(line.atv, line.number, line.mark) for line in table.reservations] == [("A", 1, b"A")]


def test_nobody_strikes_out_what_another_one_holds() -> None:
    table = ReservationTable()
    table.grant("A", ["b3"])
    assert not table.strike(request(seen=10**9), "B")
    assert table.holder("b3") == "A"


def test_a_new_life_is_granted_anew_what_it_has_not_seen() -> None:
    table = ReservationTable()
    table.begin_life("A", request())
    table.grant("A", ["b3", "c3"])
    assert table.begin_life("A", request("b3", life=2))
    assert {line.number for line in table.of("A")} == {2}
    assert not table.begin_life("A", request("b3", life=2))


@pytest.mark.parametrize(
    ("said", "regains"),
    [
        ({"life": 2}, True),
        ({"life": 1, "seq": 2}, False),
        ({"life": 2, "seen": 1}, False),
        ({"life": 2, "key": b"another"}, False),
    ],
)
def test_what_the_copies_still_have_of_the_life_before_is_its_own_again(
    said: dict[str, Any], regains: bool
) -> None:
    table = ReservationTable()
    first = replace(request(), key=b"own")
    table.begin_life("A", first)
    table.grant("A", ["b3", "c3"], first.mark)
    copied = table.reservations
    table.strike(replace(first, seen=1, holds=("c3",)), "A")
    table.begin_life("A", replace(first, **said), copied)
    assert (table.holder("b3") == "A") is regains
    if regains:
        assert {line.number for line in table.of("A")} == {2}


def test_what_another_one_was_granted_since_is_not_regained() -> None:
    table = ReservationTable()
    first = replace(request(), key=b"own")
    table.begin_life("A", first)
    table.grant("A", ["b3"], first.mark)
    copied = table.reservations
    table.strike(replace(first, seen=1), "A")
    table.grant("B", ["b3"])
    table.begin_life("A", replace(first, life=2), copied)
    assert table.holder("b3") == "B"


def test_a_place_is_never_written_down_for_two() -> None:
    table = ReservationTable()
    table.grant("A", ["b3"])
    with pytest.raises(ProtocolViolation, match="b3 is held by A"):
        table.grant("B", ["b3"])


def test_a_carried_away_vehicle_holds_nothing() -> None:
    table = ReservationTable()
    table.grant("A", ["b3"])
    assert table.remove("A", 1) == ("b3",)
    table.grant("A", ["b3"])
    assert table.remove("A", 1) == ()
    assert table.holder("b3") == "A", "an old word frees nothing that was granted since"
