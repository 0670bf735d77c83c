"""A load that a vehicle brings back to a station has its room there from the moment at which the vehicle stands at the dock."""

from __future__ import annotations

import pytest
from defaults import PLANT
from effects import committed, instructed
from msgspec.structs import replace
from spoken import rhb
from station_rig import ITEM, StationRig

from dray.body import DockReady, FillTo
from dray.messages import Docked, Phase, StockReserved, TransportCancelled, TransportOrdered
from dray.protocol.runtime.events import Effect

FULL = next(kept.capacity for kept in PLANT.storages["S1"].stocks if kept.material == ITEM)
BACK = Docked(task="M8-1", epoch=1, station="S1", item=ITEM, quantity=40, returns=True)
ORDER = TransportOrdered("T-1", "S3", ITEM, 20, 600.0)
"""It finds room beside what lies there, and none beside the returned load as well."""

BODIES = pytest.mark.parametrize(
    ("counts", "answers"), [(True, False), (True, True), (False, False), (False, True)]
)


def full_but(room: int, *, counts: bool, answers: bool, incarnation: int = 1) -> StationRig:
    """A station with room for so many shafts."""
    rig = StationRig(FULL - room, incarnation=incarnation)
    rig.counts, rig.answers = counts, answers
    return rig


def brought_back(*, counts: bool, answers: bool, room: int = 50) -> StationRig:
    """ATV1 stands at the dock with 40 shafts that nobody wants any more, and was let in."""
    rig = full_but(room, counts=counts, answers=answers)
    rig.start()
    let_in(rig)
    return rig


def let_in(rig: StationRig) -> None:
    rig.on_message("ATV1", BACK)
    if rig.answers:
        rig.report(DockReady("ATV1"))


def beats(rig: StationRig, *, aboard: bool, node: str = "") -> list[Effect]:
    """ATV1 tells where it stands, with or without its load; without it, its task has ended."""
    rig.run(rig.now_s + 1.0)
    beat = rhb("ATV1", 100 + int(rig.now_s), rig.now_s, task="M8-1")
    assert beat.task is not None
    brief = replace(beat.task, phase=Phase.RETURNING) if aboard else None
    load, quantity = (ITEM, 40) if aboard else ("", 0)
    where = node or PLANT.node_of("S1")
    return rig.on_message("ATV1", replace(beat, task=brief, node=where, load=load, load_quantity=quantity))


@BODIES
def test_a_call_waits_that_finds_no_room_beside_it(counts: bool, answers: bool) -> None:
    rig = brought_back(counts=counts, answers=answers)
    rig.on_message("gateway", ORDER)
    beats(rig, aboard=True)
    assert rig.level.on_order == 0
    # The vehicle is heard without the load before, or after, the body has booked it.
    if counts:
        rig.changes(40, "ATV1")
    beats(rig, aboard=False)
    assert rig.level.on_order == 0
    if not counts:
        rig.changes(40, "ATV1")
    assert (rig.level.level, rig.level.on_order) == (FULL - 10, 0)
    rig.changes(-10)
    assert rig.level.on_order == 20


@BODIES
def test_a_call_that_finds_room_beside_it_does_not_wait(counts: bool, answers: bool) -> None:
    rig = brought_back(counts=counts, answers=answers, room=60)
    rig.on_message("gateway", ORDER)
    assert rig.level.on_order == 20


@BODIES
def test_its_room_is_free_again_when_the_vehicle_has_left_with_it(counts: bool, answers: bool) -> None:
    rig = brought_back(counts=counts, answers=answers)
    rig.on_message("gateway", ORDER)
    beats(rig, aboard=True, node="c1")
    assert rig.level.on_order == 20


@BODIES
def test_the_next_life_keeps_its_room(counts: bool, answers: bool) -> None:
    first = brought_back(counts=counts, answers=answers)
    rig = full_but(50, counts=counts, answers=answers, incarnation=2)
    rig.opened = dict.fromkeys(("ATV1",)) if answers or not counts else {}
    rig.memory = committed(first.all)
    rig.start()
    rig.on_message("gateway", ORDER)
    beats(rig, aboard=True)
    assert rig.level.on_order == 0


@BODIES
def test_the_load_of_a_carrier_that_was_replaced_needs_room_beside_that_of_its_transport(
    counts: bool, answers: bool
) -> None:
    rig = full_but(70, counts=counts, answers=answers)
    rig.start()
    rig.on_message("gateway", ORDER)
    rig.on_message("S3", StockReserved("T-1-1", 1, ITEM, 20))
    rig.on_message("ATV1", replace(BACK, task="T-1-1"))
    if answers:
        rig.report(DockReady("ATV1"))
    rig.on_message("gateway", replace(ORDER, transport="T-2"))
    assert rig.level.on_order == 20


@BODIES
def test_what_was_on_order_before_it_came_stays_on_order(counts: bool, answers: bool) -> None:
    rig = full_but(50, counts=counts, answers=answers)
    rig.start()
    rig.on_message("gateway", ORDER)
    let_in(rig)
    assert rig.level.on_order == 20
    # Another call gets its place only where both find room.
    rig.on_message("gateway", replace(ORDER, transport="T-2"))
    assert rig.level.on_order == 20
    rig.on_message("gateway", TransportCancelled("T-1"))
    assert rig.level.on_order == 0


def test_a_storage_that_fills_itself_leaves_its_room() -> None:
    rig = brought_back(counts=True, answers=False)

    def limits(effects: list[Effect]) -> list[int]:
        return [told.quantity for told in instructed(effects, FillTo) if told.item == ITEM]

    assert limits(rig.all) == [FULL, FULL - 40]
    assert limits(beats(rig, aboard=True, node="c1")) == [FULL]


def test_a_load_that_is_counted_while_its_vehicle_still_stands_there_has_its_room_once() -> None:
    rig = brought_back(counts=True, answers=False, room=60)
    rig.changes(40, "ATV1")
    rig.on_message("gateway", ORDER)
    assert (rig.level.level, rig.level.on_order) == (FULL - 20, 20)


def test_a_load_of_a_vehicle_that_is_carried_away_has_no_room_any_more() -> None:
    rig = brought_back(counts=True, answers=False)
    rig.on_message("gateway", ORDER)
    assert rig.level.on_order == 0
    rig.agent._flow.on_carried_away("ATV1")  # type: ignore[attr-defined]
    rig.run(rig.now_s + 10.0)
    assert rig.level.on_order == 20


def test_a_new_order_is_told_at_once() -> None:
    rig = full_but(50, counts=True, answers=False)
    rig.start()
    rig.run(rig.now_s + 0.5)
    rig.on_message("gateway", ORDER)
    assert rig.level.on_order == 20
