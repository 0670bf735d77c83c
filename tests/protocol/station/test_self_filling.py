"""A storage that fills itself is told to leave room for what is on order to it, whenever that changes."""

from __future__ import annotations

import msgspec
from defaults import PLANT
from effects import instructed
from storage_rig import ORDER, StorageRig, restarted, started

from dray.body import FillTo, Refill
from dray.messages import Phase, StockAsked, TransportCancelled
from dray.plant import Plant
from dray.protocol.runtime.events import Effect
from dray.protocol.transports.transports import RECOVERY_WAIT_S

FULL = next(kept.capacity for kept in PLANT.storages["S1"].stocks if kept.material == ORDER.item)
LOT = ORDER.quantity


def limits(effects: list[Effect]) -> list[int]:
    """The limits told for shafts."""
    return [told.quantity for told in instructed(effects, FillTo) if told.item == ORDER.item]


def with_refill(refill: str) -> Plant:
    file = PLANT.file
    storages = tuple(
        msgspec.structs.replace(each, refill=refill) if each.id == "S1" else each for each in file.storages
    )
    return Plant(msgspec.structs.replace(file, storages=storages))


def test_where_nothing_is_on_order_it_may_fill_up() -> None:
    assert limits(started().all) == [FULL]


def test_a_call_keeps_its_room_from_its_order_to_its_count() -> None:
    rig = started()
    before = len(rig.all)
    rig.asks()
    assert limits(rig.all[before:]) == [FULL - LOT]
    rig.asks(msgspec.structs.replace(ORDER, transport="T-2"))
    rig.asks(msgspec.structs.replace(ORDER, transport="T-2"))
    assert limits(rig.all[before:]) == [FULL - LOT, FULL - 2 * LOT]
    rig.carried()
    rig.beats_in(Phase.CARRYING)
    rig.put_down()
    assert limits(rig.all[before:]) == [FULL - LOT, FULL - 2 * LOT, FULL - LOT]


def test_a_call_that_waits_for_room_keeps_none() -> None:
    rig = started(stock=FULL - LOT + 1)
    rig.asks()
    assert limits(rig.all) == [FULL]


def test_a_cancelled_call_gives_its_room_back() -> None:
    rig = started()
    rig.asks()
    assert limits(rig.on_message("gateway", TransportCancelled(ORDER.transport))) == [FULL]


def test_while_machines_wait_only_a_load_with_a_carrier_keeps_its_room() -> None:
    rig = started(stock=0)
    rig.asks()
    effects = rig.on_message("M8", StockAsked("M8-1", 1, ORDER.item, LOT))
    assert limits(effects) == [FULL]
    assert Refill(item=ORDER.item) in instructed(effects, Refill)
    before = len(rig.all)
    rig.carried()
    rig.on_message("M8", StockAsked("M8-1", 1, ORDER.item, LOT))
    rig.run(rig.now_s + 1.0)
    assert limits(rig.all[before:]) == [FULL - LOT]


def test_its_next_life_tells_it_again() -> None:
    rig = started()
    rig.asks()
    rig.carried()
    rig.beats_in(Phase.CARRYING)
    assert limits(restarted(rig).all) == [FULL - LOT]


def test_a_life_without_notes_tells_nothing_before_it_has_heard_the_carriers() -> None:
    rig = StorageRig(incarnation=2)
    rig.start()
    rig.keeps_beating(Phase.CARRYING, RECOVERY_WAIT_S - 1.0)
    assert not limits(rig.all)
    rig.keeps_beating(Phase.CARRYING, RECOVERY_WAIT_S + 2.0)
    assert limits(rig.all) == [FULL - LOT]


def test_where_something_else_refills_it_it_is_told_nothing() -> None:
    for refill in ("vehicles", "none"):
        rig = started(plant=with_refill(refill))
        rig.asks()
        assert not limits(rig.all)
