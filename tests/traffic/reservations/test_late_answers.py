"""Vehicles that tell what they hold after a recovery poll: each key once, and a stranger only where it is heard to be."""

from __future__ import annotations

import msgspec
import pytest
from replica import HERE, PLACES, beat, request

from dray.messages.base import COUNT_MAX
from dray.protocol.traffic.neighbours import Neighbours
from dray.protocol.traffic.numbers import FAR, VERSION_LEAP
from dray.protocol.traffic.reservations.late_answers import LateAnswers
from dray.protocol.traffic.reservations.reach import Reach
from dray.protocol.traffic.reservations.reservation_table import ReservationTable

STRANGER = "ATV77"


@pytest.fixture
def neighbours() -> Neighbours:
    return Neighbours()


@pytest.fixture
def late(neighbours: Neighbours) -> LateAnswers:
    """After a recovery poll in which ATV1 alone has told."""
    late = LateAnswers(Reach(PLACES, neighbours, ("ATV1",)))
    late.start([("ATV1", b"")])
    return late


def test_who_has_told_in_the_recovery_poll_tells_nothing_more(late: LateAnswers) -> None:
    table = ReservationTable()
    assert late.on_request("ATV1", request(HERE), table, 0.0)
    assert table.reservations == ()


def test_a_stranger_counts_when_it_is_heard_where_it_says_that_it_is(
    late: LateAnswers, neighbours: Neighbours
) -> None:
    table = ReservationTable()
    assert not late.on_request(STRANGER, request(HERE), table, 0.0)
    assert late.unknown == {STRANGER}
    neighbours.on_vehicle(beat(atv=STRANGER), 1.0)
    assert late.on_request(STRANGER, request(HERE), table, 1.0)
    assert table.holder(HERE) == STRANGER
    assert late.unknown == set()


def test_who_says_to_have_seen_what_is_beyond_all_numbers_does_not_move_the_tables(late: LateAnswers) -> None:
    """Another key speaks in the name of one that has told, and holds where that one may be."""
    table = ReservationTable()
    forged = msgspec.structs.replace(request(HERE), key=b"k" * 32, seen=COUNT_MAX)
    assert not late.on_request("ATV1", forged, table, 0.0)
    assert (table.version, table.reservations) == (0, ())


def test_one_that_says_to_have_seen_the_last_version_that_is_believed_leaves_room_above(
    late: LateAnswers,
) -> None:
    table = ReservationTable(version=7)
    forged = msgspec.structs.replace(request(HERE), key=b"k" * 32, seen=FAR)
    assert late.on_request("ATV1", forged, table, 0.0)
    assert FAR // 2 <= table.version < FAR // 2 + VERSION_LEAP


def test_a_table_that_was_not_made_from_a_recovery_poll_knows_what_is_held(late: LateAnswers) -> None:
    late.start(None)
    table = ReservationTable()
    assert late.on_request(STRANGER, request(HERE), table, 0.0)
    assert table.holder(HERE) == ""
