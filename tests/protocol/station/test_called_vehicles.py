"""What somebody who asks for a plain transport wants of its vehicle: which one, until when, and what it can."""

from __future__ import annotations

import msgspec
import pytest
from effects import committed, published, sent
from spoken import bid
from storage_rig import ORDER, TASK, StorageRig, restarted, started

from dray.memory import TransportMemory
from dray.messages import (
    Phase,
    Reason,
    Resigned,
    Role,
    StockAsked,
    TaskAnnounced,
    Transport,
    TransportAnswered,
    TransportState,
)
from dray.protocol.runtime.events import Ignore
from dray.protocol.transports.called import LOOK_AGAIN_S


def test_only_the_vehicle_that_was_named_may_carry_it() -> None:
    rig = started()
    rig.asks(msgspec.structs.replace(ORDER, vehicle="ATV7"))
    rig.carried()
    assert TransportState.ASSIGNED not in rig.states


WISH = msgspec.structs.replace(ORDER, vehicle="ATV1", vehicle_until_s=20.0)


def wanted(rig: StorageRig) -> dict[str, str]:
    """By the name of each task that was announced, the only vehicle that may carry it."""
    announced = published(rig.all, TaskAnnounced)
    return {each.task: each.work.vehicle for each in announced if isinstance(each.work, Transport)}


def test_a_wish_is_held_until_its_time_and_then_any_vehicle_may_carry() -> None:
    rig = started()
    rig.asks(WISH)
    rig.reserved()
    rig.run(19.0)
    assert wanted(rig) == {TASK: "ATV1"}
    effects = rig.on_message("ATV7", bid(100.0, task=TASK, finish_s=200.0))
    assert any(isinstance(effect, Ignore) for effect in effects)
    rig.run(21.0)
    assert [ask.task for ask in sent(rig.all, StockAsked, to="S3")][-1] == "T-1-2"
    rig.reserved("T-1-2")
    rig.run(23.0)
    assert wanted(rig) == {TASK: "ATV1", "T-1-2": ""}
    assert rig.asks(WISH) == TransportAnswered("T-1", TransportState.WAITING)


def test_a_wish_that_is_met_in_time_stays_with_its_vehicle() -> None:
    rig = started()
    rig.asks(WISH)
    rig.carried()
    rig.keeps_beating(Phase.APPROACHING, 40.0)
    assert wanted(rig) == {TASK: "ATV1"}
    rig.beats_in(Phase.CARRYING)
    rig.put_down()
    assert rig.states[-1] is TransportState.DELIVERED
    assert wanted(rig) == {TASK: "ATV1"}


def test_whoever_gives_back_what_it_was_wished_for_is_waited_for_no_longer_than_that() -> None:
    rig = started()
    rig.asks(WISH)
    rig.carried()
    rig.keeps_beating(Phase.APPROACHING, 30.0)
    rig.on_message("ATV1", Resigned(TASK, 1, Role.PRIMARY, Reason.CLOSED))
    rig.run(30.0 + 2 * LOOK_AGAIN_S)
    rig.reserved("T-1-2")
    rig.run(rig.now_s + 2.0)
    assert wanted(rig)["T-1-2"] == ""


def test_the_next_life_holds_a_wish_as_long() -> None:
    rig = started()
    rig.asks(WISH)
    rig.reserved()
    rig.run(10.0)
    after = restarted(rig)
    after.run(19.0)
    assert {*wanted(after).values()} <= {"ATV1"}
    after.run(21.0)
    [named] = {ask.task for ask in sent(after.all, StockAsked, to="S3")} - {TASK}
    after.reserved(named)
    after.run(23.0)
    assert wanted(after)[named] == ""


def test_an_order_that_names_one_vehicle_for_always_waits_for_it() -> None:
    rig = started()
    rig.asks(msgspec.structs.replace(ORDER, vehicle="ATV7"))
    rig.reserved()
    rig.run(3600.0)
    assert wanted(rig) == {TASK: "ATV7"}


def test_what_somebody_wants_of_its_vehicle_is_announced_in_every_life() -> None:
    rig = started()
    rig.asks(msgspec.structs.replace(ORDER, ability="pallet"))
    rig.reserved()
    works = [each.work for each in published(rig.all, TaskAnnounced)]
    assert {work.needed for work in works if isinstance(work, Transport)} == {("tote", "pallet")}
    after = restarted(rig)
    after.run(120.0)
    after.reserved()
    again = [each.work for each in published(after.all, TaskAnnounced)]
    assert {work.needed for work in again if isinstance(work, Transport)} == {("tote", "pallet")}
    [note] = [each for each in committed(rig.all).values() if isinstance(each, TransportMemory)]
    assert note.ability == "pallet"


@pytest.mark.parametrize("wish", [{"vehicle": "ATV7"}, {"ability": "pallet"}])
def test_what_was_wanted_of_its_vehicle_holds_after_the_notes_were_lost(wish: dict[str, str]) -> None:
    """A carrier does not tell what was wanted of it: when it fails as well, only the order that comes again begins anything."""
    rig = started(incarnation=2)
    rig.keeps_beating(Phase.APPROACHING, until_s=11.0)
    order = msgspec.structs.replace(ORDER, **wish)
    assert rig.asks(order) == TransportAnswered("T-1", TransportState.ASSIGNED)
    rig.run(30.0)
    assert published(rig.all, TaskAnnounced) == []
    again = sent(rig.all, StockAsked, to="S3")[-1].task
    rig.reserved(again)
    works = [each.work for each in published(rig.all, TaskAnnounced) if each.task == again]
    named = [(work.vehicle, work.also) for work in works if isinstance(work, Transport)]
    assert named == [(order.vehicle, order.ability)]


def test_when_the_only_vehicle_dies_with_the_load_it_is_asked_again_and_nobody_else() -> None:
    rig = started()
    rig.asks(msgspec.structs.replace(ORDER, vehicle="ATV1"))
    rig.carried()
    rig.beats_in(Phase.CARRYING)
    rig.run(120.0)
    again = [each for each in published(rig.all, TaskAnnounced) if each.epoch > 1]
    assert again
    assert {each.role for each in published(rig.all, TaskAnnounced)} == {Role.PRIMARY}
    assert set(wanted(rig).values()) == {"ATV1"}
