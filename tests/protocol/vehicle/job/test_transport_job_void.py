"""A committed transport whose contract is void: what becomes of the load."""

from __future__ import annotations

import pytest
from defaults import PLANT
from effects import facts, instructed, sent
from trip import GOODS, ROUTES, Trip

from dray.body import Drive, Drop, Pick
from dray.messages import (
    THING,
    Docked,
    Handover,
    Message,
    Phase,
    Reason,
    Superseded,
    Withdrawn,
)
from dray.messages.fact import PhaseEntered
from dray.protocol.runtime.events import NEVER_S
from dray.protocol.vehicle.job.job_messages import GIVE_UP_AFTER
from dray.protocol.vehicle.job.job_moves import RETRY_S
from dray.protocol.vehicle.job.job_state import JobState
from dray.protocol.vehicle.job.transport_job import REFUGE_HELD_S, TRIES, TransportJob


@pytest.mark.parametrize(
    ("message", "reason"),
    [
        (Superseded(task="M8-1", epoch=2), "superseded"),
        (Withdrawn(task="M8-1", epoch=1, reason=Reason.NOT_NEEDED), "withdrawn"),
    ],
)
def test_without_a_load_a_void_contract_just_ends(message: Message, reason: str) -> None:
    trip = Trip()
    trip.hears(message)
    assert trip.job.ended == reason
    assert trip.life.timers.next_s == NEVER_S


def test_a_superseded_primary_returns_its_load_to_the_nearest_storage_that_keeps_it() -> None:
    trip = Trip().to_carrying()
    trip.superseded()
    assert trip.job.phase is Phase.RETURNING
    assert trip.job.ended is None
    here = trip.driver.next_node
    keeping = PLANT.storages_of("shaft")
    nearest = min(keeping, key=lambda each: ROUTES.duration_s(here, PLANT.node_of(each)))
    assert instructed(trip.out, Drive)[-1].nodes[-1] == PLANT.node_of(nearest)
    trip.arrives()
    assert instructed(trip.out, Drop)[-1].station == nearest
    trip.done(Drop)
    assert trip.job.ended == Reason.SUPERSEDED


def test_a_superseded_primary_at_the_dock_puts_nothing_down_there() -> None:
    trip = Trip().to_unloading()
    trip.superseded()
    assert trip.job.phase is Phase.RETURNING
    trip.opened()
    assert instructed(trip.out, Drop) == []


def test_a_contract_that_is_void_while_it_loads_ends_after_the_load_is_back() -> None:
    trip = Trip().to_loading()
    trip.superseded()
    assert trip.job.ended is None
    trip.done(Pick)
    assert trip.job.phase is Phase.RETURNING
    trip.arrives() if not instructed(trip.out, Drop) else None
    trip.done(Drop)
    assert trip.job.ended == Reason.SUPERSEDED


@pytest.mark.parametrize(("fetched", "back"), [("S3", "S3"), ("M8", "S5")])
def test_a_thing_that_is_called_off_while_it_is_loaded_goes_back_to_its_storage_or_the_nearest(
    fetched: str, back: str
) -> None:
    trip = Trip(source=fetched, sources=(fetched,), destination="S1", item=THING, quantity=1).to_loading()
    if fetched == "M8":
        trip.opened("M8")
    trip.hears(Withdrawn(task="M8-1", epoch=1, reason=Reason.NOT_NEEDED))
    assert trip.job.ended is None
    trip.done(Pick)
    assert trip.job.phase is Phase.RETURNING
    if not instructed(trip.out, Drop):
        trip.arrives()
    assert instructed(trip.out, Drop)[-1].station == back
    trip.done(Drop)
    assert trip.job.ended == Reason.WITHDRAWN
    assert sent(trip.out, Handover) == []


def started_again(trip: Trip) -> Trip:
    """The agent of the same vehicle in its next life, which does not know what its body does at this moment."""
    trip.job = TransportJob(
        trip.job.memory(), plant=PLANT, vehicle_type="light", driver=trip.driver, life=trip.life
    )
    trip.job.resume(trip.load, trip.now_s)
    return trip


@pytest.mark.parametrize("is_void_before", [False, True])
def test_a_pick_of_an_earlier_life_is_waited_for_when_the_contract_is_void(is_void_before: bool) -> None:
    trip = Trip().to_loading()
    if is_void_before:
        trip.superseded()
    started_again(trip)
    trip.superseded()
    # Its body goes on loading: the source must hear of it, and the vehicle is not free.
    assert (trip.job.ended, trip.job.phase) == (None, Phase.LOADING)
    trip.waits()
    assert trip.job.ended is None
    trip.load = trip.job.work.item
    trip.waits()
    assert trip.job.phase is Phase.RETURNING


def test_no_pick_of_an_earlier_life_is_waited_for_longer_than_it_takes() -> None:
    trip = started_again(Trip().to_loading())
    trip.superseded()
    while not trip.job.ended:
        trip.waits()
    assert trip.job.ended == Reason.SUPERSEDED
    load_s = PLANT.vehicle_types["light"].load_s
    assert load_s <= trip.now_s <= load_s + RETRY_S


def test_no_pick_of_an_earlier_life_is_waited_for_elsewhere_or_later() -> None:
    trip = started_again(Trip().to_loading())
    trip.now_s += PLANT.vehicle_types["light"].load_s
    trip.superseded()
    assert trip.job.ended == Reason.SUPERSEDED
    trip = started_again(Trip())
    trip.superseded()
    assert trip.job.ended == Reason.SUPERSEDED


def test_another_load_on_board_is_not_the_earlier_pick() -> None:
    trip = started_again(Trip().to_loading())
    trip.superseded()
    trip.load = "bearing"
    trip.waits()
    assert trip.job.ended == Reason.SUPERSEDED


def test_a_contract_that_is_void_while_a_pick_fails_ends() -> None:
    trip = Trip().to_loading()
    trip.superseded()
    trip.fails(Pick)
    assert trip.job.ended == Reason.SUPERSEDED


def test_a_contract_that_is_void_while_a_drop_fails_ends_after_the_load_is_back() -> None:
    trip = Trip().to_dropping()
    trip.superseded()
    trip.fails(Drop)
    assert trip.job.phase is Phase.RETURNING
    trip.arrives()
    trip.done(Drop)
    assert trip.job.ended == Reason.SUPERSEDED


def test_a_contract_that_is_void_while_it_unloads_ends_without_a_handover() -> None:
    trip = Trip().to_dropping()
    trip.superseded()
    assert trip.job.ended is None
    trip.done(Drop)
    assert trip.job.ended == Reason.SUPERSEDED
    assert sent(trip.out, Handover) == []
    assert trip.life.timers.next_s == NEVER_S


def test_goods_of_a_void_contract_are_set_aside_at_the_delivery_warehouse() -> None:
    trip = Trip(source="M8", **GOODS).to_loading()
    trip.opened("M8")
    trip.done(Pick)
    trip.superseded()
    assert trip.job.phase is Phase.RETURNING
    trip.arrives()
    drop = instructed(trip.out, Drop)[-1]
    assert (drop.station, drop.goal) == ("DELIVERY", "")
    trip.done(Drop)
    assert trip.job.ended == Reason.SUPERSEDED


def test_material_for_which_no_storage_has_room_goes_back_to_where_it_came_from() -> None:
    trip = Trip().to_carrying()
    trip.superseded()
    full = []
    for _ in PLANT.storages_of("shaft"):
        trip.arrives()
        full.append(instructed(trip.out, Drop)[-1].station)
        for _ in range(TRIES - 1):
            trip.fails(Drop)
            trip.waits()
        trip.fails(Drop)
    assert sorted(full) == sorted(PLANT.storages_of("shaft"))
    trip.arrives()
    assert instructed(trip.out, Drop)[-1].station in PLANT.source_warehouses
    trip.done(Drop)
    assert trip.job.ended == Reason.SUPERSEDED


def test_a_load_that_could_not_be_put_back_is_tried_again_after_a_while() -> None:
    trip = Trip().to_carrying()
    trip.superseded()
    trip.arrives()
    trip.fails(Drop)
    assert len(instructed(trip.out, Drop)) == 1
    trip.waits()
    assert trip.now_s == RETRY_S
    assert len(instructed(trip.out, Drop)) == 2
    trip.done(Drop)
    assert trip.job.ended == Reason.SUPERSEDED


def brought_back() -> Trip:
    """It stands at the storage with a load that nobody wants, and has no answer yet."""
    trip = Trip().to_carrying()
    trip.takes_back = False
    trip.superseded()
    trip.arrives()
    return trip


def refuge(trip: Trip) -> str:
    """Where it has asked last to put its load down."""
    asked = sent(trip.out, Docked)[-1]
    assert (asked.returns, asked.item, asked.quantity) == (True, "shaft", trip.job.work.quantity)
    return asked.station


def test_what_is_brought_back_is_put_down_when_the_storage_opens_its_dock() -> None:
    trip = brought_back()
    assert instructed(trip.out, Drop) == []
    trip.held(refuge(trip))
    trip.waits()
    assert instructed(trip.out, Drop) == []
    trip.opened(refuge(trip))
    assert instructed(trip.out, Drop)[-1].station == refuge(trip)
    trip.done(Drop)
    assert trip.job.ended == Reason.SUPERSEDED


def test_where_a_station_lets_nothing_in_for_a_minute_the_load_is_brought_elsewhere() -> None:
    trip = brought_back()
    full = refuge(trip)
    while trip.now_s < REFUGE_HELD_S:
        assert trip.job.state is JobState.AT_REFUGE
        trip.held(full)
        trip.waits()
    trip.held(full)
    assert trip.job.state is JobState.RETURNING
    trip.arrives()
    assert refuge(trip) != full


def test_who_hears_only_that_it_is_superseded_where_it_brings_its_load_back_goes_elsewhere() -> None:
    trip = brought_back()
    deaf = refuge(trip)
    for _ in range(3 * GIVE_UP_AFTER):
        if trip.job.state is not JobState.AT_REFUGE:
            break
        trip.superseded()
        trip.waits()
    trip.arrives()
    assert refuge(trip) != deaf


def test_who_comes_back_to_the_only_storage_there_is_says_nothing_new() -> None:
    trip = Trip(item=THING, quantity=1).to_carrying()
    trip.takes_back = False
    trip.superseded()
    trip.arrives()
    for _ in range(3 * GIVE_UP_AFTER):
        trip.waits()
    assert trip.job.state is JobState.AT_REFUGE
    assert [fact.station for fact in facts(trip.out, PhaseEntered) if fact.phase is Phase.RETURNING] == ["S3"]


def test_where_no_station_answers_the_load_is_brought_elsewhere() -> None:
    trip = brought_back()
    silent = refuge(trip)
    while trip.job.state is JobState.AT_REFUGE:
        trip.waits()
    assert instructed(trip.out, Drop) == []
    trip.arrives()
    assert refuge(trip) != silent


@pytest.mark.parametrize(
    ("ours", "theirs", "void"), [(2, 1, False), (2, 2, True), (2, 3, True), (2, 0, True)]
)
def test_a_contract_is_superseded_by_its_own_epoch_a_later_one_or_the_end_of_the_task(
    ours: int, theirs: int, void: bool
) -> None:
    trip = Trip()
    trip.job.epoch = ours
    trip.hears(Superseded(task="M8-1", epoch=theirs))
    assert bool(trip.job.ended) is void


def test_a_contract_that_is_void_after_unloading_ends() -> None:
    trip = Trip().to_handing_over()
    trip.superseded()
    assert trip.job.ended == Reason.SUPERSEDED


def test_a_contract_becomes_void_once() -> None:
    trip = Trip().to_carrying()
    trip.superseded()
    trip.superseded()
    trip.hears(Withdrawn(task="M8-1", epoch=1, reason=Reason.NOT_NEEDED))
    assert trip.phases.count(Phase.RETURNING) == 1
    trip.arrives()
    trip.done(Drop)
    assert trip.job.ended == Reason.SUPERSEDED


def test_a_refused_way_back_is_asked_for_again() -> None:
    trip = Trip().to_carrying()
    trip.superseded()
    goal = instructed(trip.out, Drive)[-1].nodes[-1]
    trip.job.way_refused(0.0)
    trip.waits()
    assert instructed(trip.out, Drive)[-1].nodes[-1] == goal
