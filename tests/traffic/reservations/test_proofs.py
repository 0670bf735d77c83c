"""Requests that prove what a vehicle has given back: no later request displaces one that a replica still needs."""

from __future__ import annotations

from typing import Any

import msgspec
import pytest
from replica import DISTRICT, Replica
from trio import NAMES, Trio, is_signed, line

from dray.memory import TableMemory
from dray.messages.floor.traffic import GivenBack, PlaceRequested, TableReplicated
from dray.protocol.runtime.events import Send
from dray.protocol.runtime.life import Life
from dray.protocol.traffic.reservations import copies
from dray.protocol.traffic.reservations.copies import Copies, Kept
from dray.protocol.traffic.reservations.reservation_handling import NOTE
from dray.protocol.traffic.reservations.reservation_table import ReservationTable


def said(*holds: str, seq: int = 1, seen: int = 1, life: int = 1, key: bytes = b"A") -> PlaceRequested:
    """A request of A, under one of its name's keys."""
    return PlaceRequested(
        district="M1",
        life=life,
        seq=seq,
        epoch=0,
        rank=(0, 0.0, "A"),
        holds=holds,
        groups=(),
        seen=seen,
        stands=True,
        docked=False,
        key=key,
        signature=b"A",
    )


class Floor(Trio):
    """M1 leads. A holds `b3` in everybody's copy, and M3 is cut off since."""

    def __init__(self) -> None:
        super().__init__()
        self.leader = self.lead("M1")
        self.leader.write(1, line("A", 1, mark=b"A"))
        self.carry()
        self.cut = {"M3"}
        self.given_back = 0
        """How many proofs M3 was sent last."""

    def deliver(self, sender: str, effect: Send) -> None:
        if effect.to == "M3" and isinstance(effect.message, TableReplicated):
            self.given_back = len(effect.message.given_back)
        super().deliver(sender, effect)

    def note(self, request: PlaceRequested, **how: Any) -> None:
        self.leader.note_word("A", request, **how)

    def mend(self) -> Copies:
        """M3 is back; B is granted the place."""
        version = self.leader.kept.version + 1
        self.leader.write(version, line("B", version, mark=b"B"))
        self.carry()
        self.cut = set()
        self.leader.repeat()
        self.carry()
        return self.replicas["M3"]


def test_a_request_that_was_overtaken_on_its_way_displaces_no_proof() -> None:
    """It says that A holds the place, which A has given back since. A leader that has begun anew takes it for the newest one."""
    floor = Floor()
    floor.note(said(seq=3), struck=True, oldest=1)
    floor.leader.write(2, ())
    floor.note(said("b3", seq=2), struck=False)
    assert floor.mend().kept.version == 3


def test_what_is_said_under_another_key_of_the_same_name_displaces_no_proof() -> None:
    """A thief of A's certificate takes a place in its name when A has left, and gives it back."""
    floor = Floor()
    floor.note(said(seq=3), struck=True, oldest=1)
    floor.leader.write(2, line("A", 2, mark=b"T"))
    floor.note(said(seen=2, key=b"T"), struck=True, oldest=2)
    assert floor.mend().kept.version == 3


def test_a_proof_from_before_a_recovery_poll_with_higher_numbers_displaces_no_later_one() -> None:
    floor = Floor()
    floor.note(said("b3", seq=3, seen=1000), struck=True)
    floor.note(said(seq=4, seen=1), struck=True, oldest=1)
    assert floor.mend().kept.version == 2


def test_a_leader_that_starts_again_has_them_still() -> None:
    """A has started again, too, and has seen no grant since: it cannot say its word once more."""
    floor = Floor()
    floor.note(said(seq=3), struck=True, oldest=1)
    floor.leader.write(2, ())
    floor.carry()
    floor.replicas["M1"] = Copies("M1", "M1", NAMES, floor.leader.kept, floor.lives["M1"], is_signed)
    floor.leader = floor.lead("M1")
    floor.note(said(life=2, seen=0), struck=False)
    assert floor.mend().kept.version == 3
    floor.leader.write(4, line("B", 4, mark=b"B"))
    assert not floor.leader.kept.given_back, "all have copied what it proves"


def test_a_table_that_one_keeps_alone_needs_none() -> None:
    alone = Copies("M1", "M1", ("M1",), Kept(), Life(), is_signed)
    alone.seek()
    alone.note_word("A", said(), struck=True, oldest=1)
    alone.write(2, ())
    assert not alone.kept.given_back


def test_they_are_journalled_with_the_table() -> None:
    proof = GivenBack(atv="A", request=said(seq=3))
    replica = Replica({NOTE + DISTRICT: TableMemory(0, 0, 1, given_back=(proof,))})
    (commit,) = replica.reservations.commits()
    assert isinstance(commit.note, TableMemory)
    assert msgspec.json.decode(msgspec.json.encode(commit.note), type=TableMemory).given_back == (proof,)


def test_a_vehicle_that_has_started_again_displaces_no_proof_before_it_has_seen_as_much() -> None:
    floor = Floor()
    floor.note(said(seq=3), struck=True, oldest=1)
    floor.leader.write(2, ())
    floor.note(said("b3", life=2, seen=0), struck=False)
    assert floor.mend().kept.version == 3


def test_the_keys_that_a_thief_makes_up_are_not_kept_for_a_replica_that_never_saw_their_lines(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """As many as may be under way to it are kept: 50 here."""
    monkeypatch.setattr(copies, "UNDER_WAY_MAX", 50)
    floor, keys = Floor(), 150
    floor.note(said(seq=3), struck=True, oldest=1)
    for number in range(2, keys + 2):
        mark = b"T%d" % number
        floor.leader.write(number, line("A", number, mark=mark))
        floor.carry()
        floor.note(said(seen=number, key=mark), struck=True, oldest=number)
    assert floor.mend().kept.version == keys + 2
    assert 1 < floor.given_back <= 51


def test_a_proof_is_sent_also_where_the_line_is_copied_and_not_yet_acknowledged() -> None:
    """M3 has copied A's line, and its acknowledgement is lost: the leader does not know that it has it."""
    floor = Floor()
    floor.leader.write(2, line("A", 2, mark=b"A"))
    copy = [effect for effect in floor.lives["M1"].effects if isinstance(effect, Send) and effect.to == "M3"]
    floor.carry()
    floor.deliver("M1", copy[-1])
    floor.lives["M3"].effects.clear()
    floor.note(said(seq=3, seen=2), struck=True, oldest=2)
    assert floor.mend().kept.version == 3


def test_nor_are_those_under_which_it_gives_nothing_back() -> None:
    floor = Floor()
    floor.leader.write(2, line("A", 2, mark=b"A"))
    for number in range(100):
        floor.note(said("b3", key=b"T%d" % number), struck=False)
    floor.note(said(seq=3, seen=2), struck=True, oldest=1)
    assert floor.mend().kept.version == 3
    assert floor.given_back <= 5


def test_a_line_with_a_new_number_needs_the_proof_where_it_has_its_first_one() -> None:
    """A replica that has missed the new life's number has the line under the first one."""
    table = ReservationTable()
    table.begin_life("A", said())
    table.grant("A", ["b3"], b"A")
    assert table.begin_life("A", said(life=2, seen=0))
    assert table.of("A")[0].number == 2
    assert table.strike(said(life=2, seen=2), "A") == 1
