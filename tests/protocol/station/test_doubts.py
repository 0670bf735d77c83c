"""A load that a storage has booked out in doubt: people are asked to count, unless its controller measures the level."""

from __future__ import annotations

import pytest
from defaults import PLANT
from effects import committed, facts, instructed, sent
from msgspec.structs import replace
from seals import granted, trusts_seals
from spoken import rhb
from station_rig import ITEM, StationRig

from dray.body import Book, DockReady, StorageState, Word, WordTaken
from dray.messages import (
    CommandAnswered,
    CommandRefusal,
    Docked,
    DoubtfulLoad,
    MachineCommand,
    MachineCommandKind,
    StationHeartbeat,
    StockFreed,
)
from dray.messages.fact import LoadDoubted
from dray.protocol.station.station import Station
from dray.protocol.transports.doubts import ASKS_AFTER_S
from dray.protocol.transports.visit import UNHEARD_S

KIND = MachineCommandKind
NAME = "S1-load-1"
DOUBT = DoubtfulLoad(NAME, "ATV1", ITEM, 40)


class ShelfRig(StationRig):
    """The station of S1, whose body does not count."""

    def __init__(self, *, measured: bool = False, people: bool = False, incarnation: int = 1) -> None:
        super().__init__(incarnation=incarnation)
        self.agent = Station("S1", PLANT, incarnation=incarnation, trusts=trusts_seals)
        self.counts, self.people, self.measured = False, people, (ITEM,) if measured else ()

    def sense(self) -> StorageState:
        return replace(super().sense(), measured=self.measured, people=self.people)

    def says(self, kind: MachineCommandKind, **said: object) -> CommandRefusal | None:
        """A person's word to a controller; why it was refused."""
        command = replace(
            MachineCommand(command=f"C{len(self.all)}", kind=kind, issued_by="Maria"), **{"task": NAME} | said
        )
        [answer] = sent(self.on_message("gateway", granted("S1", command)), CommandAnswered)
        return answer.reason

    def counted(
        self, kind: MachineCommandKind, quantity: int, vehicle: str = "", *, taken: bool = True
    ) -> None:
        """A person's word, which the body has taken or refused."""
        command = MachineCommand(
            command="C1", kind=kind, item=ITEM, quantity=quantity, vehicle=vehicle, issued_by="Maria"
        )
        [word] = instructed(self.on_message("gateway", granted("S1", command)), Word)
        self.report(WordTaken(word.key, None if taken else CommandRefusal.UNLIKELY))

    def asked(self) -> tuple[DoubtfulLoad, ...]:
        """What the heartbeats ask for, once a vehicle that remembers would have told."""
        self.run(self.now_s + ASKS_AFTER_S + 20.0)
        return self.heartbeats(StationHeartbeat)[-1].doubts


def in_doubt(*, measured: bool = False, people: bool = False) -> ShelfRig:
    """ATV1 was let in to fetch 40 shafts, and is heard much later elsewhere without its task, of which M8 knows nothing."""
    rig = ShelfRig(measured=measured, people=people)
    rig.start()
    rig.asks("M8-1")
    rig.docks("ATV1", "M8-1")
    rig.run(rig.now_s + 2 * UNHEARD_S)
    rig.on_message("ATV1", replace(rhb("ATV1", 1000, rig.now_s), node="c1"))
    rig.on_message("M8", StockFreed("M8-1", fetched=True))
    rig.changes(-40, "ATV1")
    return rig


def test_what_a_storage_booked_out_in_doubt_is_asked_for_until_a_person_has_counted() -> None:
    rig = in_doubt()
    assert rig.asked() == (DOUBT,)
    assert facts(rig.all, LoadDoubted) == [LoadDoubted(NAME, "ATV1", ITEM, 40, brought=False, task="M8-1")]
    assert rig.says(KIND.LOAD_THERE) is None
    assert instructed(rig.all, Book)[-1] == Book("ATV1", ITEM, 40, task=NAME, epoch=1)
    rig.changes(40, "ATV1")
    assert (rig.asked(), rig.level.level) == ((), 100)


def test_what_its_controller_measures_is_asked_of_nobody() -> None:
    rig = in_doubt(measured=True)
    assert instructed(rig.all, Book) == [Book("ATV1", ITEM, -40, task="M8-1", epoch=1)]
    assert rig.asked() == ()


@pytest.mark.parametrize("let_in", [True, False])
def test_a_load_that_was_perhaps_put_back_is_asked_for_if_its_vehicle_was_let_in(*, let_in: bool) -> None:
    rig = ShelfRig()
    rig.answers = True
    rig.start()
    rig.on_message("ATV1", Docked("M8-1", 1, "S1", ITEM, 40, returns=True))
    if let_in:
        rig.report(DockReady("ATV1"))
    rig.run(rig.now_s + 2 * UNHEARD_S)
    rig.on_message("ATV1", replace(rhb("ATV1", 1000, rig.now_s), node="c1"))
    assert rig.asked() == ((replace(DOUBT, brought=True),) if let_in else ())
    if let_in:
        assert rig.says(KIND.LOAD_THERE) is None
    found = [Book("ATV1", ITEM, 40, task="M8-1", epoch=1)] if let_in else []
    assert instructed(rig.all, Book) == found


@pytest.mark.parametrize(
    ("kind", "vehicle", "taken", "ends"),
    [
        (KIND.STOCK_IS, "", True, True),
        (KIND.STOCK_IS, "", False, False),
        (KIND.TAKEN, "ATV1", True, True),
        (KIND.TAKEN, "ATV2", True, False),
        (KIND.TAKEN, "", True, False),
    ],
)
def test_where_people_are_the_body_what_they_count_settles_it(
    kind: MachineCommandKind, vehicle: str, *, taken: bool, ends: bool
) -> None:
    rig = in_doubt(people=True)
    assert rig.asked() == (DOUBT,)
    rig.counted(kind, 60, vehicle, taken=taken)
    assert rig.asked() == (() if ends else (DOUBT,))


def test_the_next_life_asks_on() -> None:
    before = in_doubt()
    before.asked()
    rig = ShelfRig(incarnation=2)
    rig.memory, rig.now_s, rig.stock, rig.seq = committed(before.all), before.now_s, before.stock, before.seq
    rig.start()
    assert rig.asked() == (DOUBT,)
    assert rig.says(KIND.LOAD_MISSING) is None
    assert (rig.asked(), instructed(rig.all, Book)) == ((), [])
