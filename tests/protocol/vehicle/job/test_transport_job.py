"""A committed transport, as its carrier lives it: the straight way, and what is said or tried again."""

from __future__ import annotations

import pytest
from defaults import PLANT
from effects import instructed, sent
from trip import GOODS, ROUTES, Trip

from dray.body import Drive, Drop, Pick
from dray.messages import (
    Docked,
    Handover,
    HandoverAccepted,
    Phase,
    Reason,
    Resigned,
    Role,
    Withdrawn,
)
from dray.protocol.runtime.events import NEVER_S
from dray.protocol.runtime.retransmission import ASK_AGAIN_S
from dray.protocol.vehicle.job.job_messages import GIVE_UP_AFTER, HELD_ASK_AGAIN_S
from dray.protocol.vehicle.job.job_moves import RETRY_S
from dray.protocol.vehicle.job.transport_job import TRIES, WAITS_AT_LEAST_S, TransportJob


def test_a_transport_goes_through_its_phases_and_ends_when_the_handover_is_accepted() -> None:
    trip = Trip().to_handing_over()
    trip.hears(HandoverAccepted(task="M8-1", epoch=1))
    assert trip.phases == [
        Phase.APPROACHING,
        Phase.LOADING,
        Phase.CARRYING,
        Phase.UNLOADING,
        Phase.HANDING_OVER,
    ]
    assert trip.job.ended == Reason.HANDED_OVER
    assert trip.life.timers.next_s == NEVER_S


def test_it_drives_to_the_source_and_then_to_the_destination() -> None:
    trip = Trip().to_carrying()
    assert [way.nodes[-1] for way in instructed(trip.out, Drive)] == ["s3", "m8"]


def test_a_vehicle_that_stands_at_the_source_loads_at_once() -> None:
    trip = Trip(node="s3")
    assert instructed(trip.out, Drive) == []
    assert trip.phases == [Phase.APPROACHING, Phase.LOADING]
    trip.opened("S3")
    [pick] = instructed(trip.out, Pick)
    assert (pick.station, pick.item, pick.quantity) == ("S3", "shaft", 40)


def test_nothing_is_fetched_before_the_station_of_the_storage_has_opened_its_dock() -> None:
    trip = Trip()
    trip.arrives(opens=False)
    asked = Docked(task="M8-1", epoch=1, station="S3", item="shaft", quantity=40)
    assert sent(trip.out, Docked, to="S3") == [asked], "the station may have lost its notes"
    assert instructed(trip.out, Pick) == []
    trip.opened("S3")
    assert len(instructed(trip.out, Pick)) == 1


def test_a_storage_that_has_nothing_is_waited_at_as_long_as_was_promised_and_no_longer() -> None:
    trip = Trip()
    trip.now_s = 20.0
    trip.arrives(opens=False)
    light = PLANT.vehicle_types["light"]
    rest_s = light.load_s + ROUTES.duration_s("s3", PLANT.node_of("M8")) + light.unload_s
    while trip.now_s + rest_s <= 100.0:
        trip.held("S3")
        assert sent(trip.out, Resigned) == []
        trip.waits()
    assert trip.now_s > 20.0 + WAITS_AT_LEAST_S
    trip.held("S3")
    [resigned] = sent(trip.out, Resigned, to="M8")
    assert (resigned.short, resigned.reason) == ("S3", Reason.DOCK_HELD)
    assert resigned.detail == "the buffer is full"
    trip.hears(Withdrawn(task="M8-1", epoch=1, reason=Reason.NOT_NEEDED))
    assert trip.job.ended == Reason.DOCK_HELD


def test_who_comes_late_to_a_storage_that_has_nothing_waits_a_moment() -> None:
    trip = Trip()
    trip.now_s = 200.0
    trip.arrives(opens=False)
    trip.held("S3")
    assert sent(trip.out, Resigned) == [], "its station may have been started again a moment ago"
    trip.now_s += WAITS_AT_LEAST_S
    trip.held("S3")
    assert len(sent(trip.out, Resigned, to="M8")) == 1


def test_a_task_is_given_back_when_the_station_of_the_storage_does_not_answer() -> None:
    trip = Trip()
    trip.arrives(opens=False)
    for _ in range(GIVE_UP_AFTER):
        trip.waits()
    [resigned] = sent(trip.out, Resigned, to="M8")
    assert (resigned.short, resigned.reason) == ("S3", Reason.SOURCE_SILENT)


def test_nothing_is_put_down_before_the_coordinator_has_opened_the_dock() -> None:
    trip = Trip().to_unloading()
    assert sent(trip.out, Docked, to="M8") == [Docked(task="M8-1", epoch=1, station="M8")]
    assert instructed(trip.out, Drop) == []
    trip.opened()
    [drop] = instructed(trip.out, Drop)
    assert drop.station == "M8"


def test_goods_are_not_fetched_before_their_machine_has_opened_its_dock() -> None:
    trip = Trip(source="M8", **GOODS).to_loading()
    assert sent(trip.out, Docked, to="M8") == [Docked(task="M8-1", epoch=1, station="M8")]
    assert instructed(trip.out, Pick) == []
    trip.opened("M8")
    trip.done(Pick)
    trip.arrives()
    assert len(sent(trip.out, Docked, to="M8")) == 1, "the gate fences there, and nobody is asked"
    assert instructed(trip.out, Drop)[-1] == Drop(order=4, station="DELIVERY", goal="G8")
    trip.opened("DELIVERY")
    assert instructed(trip.out, Drop)[-1].station == "DELIVERY"


def test_goods_that_the_gate_refuses_are_given_up_after_as_many_tries_over_all_lives() -> None:
    trip = Trip(source="M8", **GOODS).to_loading()
    trip.opened("M8")
    trip.done(Pick)
    trip.arrives()
    for _ in range(TRIES - 1):
        trip.fails(Drop)
        trip.waits()
    trip.job = TransportJob(
        trip.job.memory(), plant=PLANT, vehicle_type="light", driver=trip.driver, life=trip.life
    )
    trip.job.resume("pump-p3", trip.now_s)
    trip.fails(Drop)
    assert [(said.reason, said.detail) for said in sent(trip.out, Resigned)] == [
        (Reason.GATE_REFUSED, "no contact")
    ]


def test_the_heartbeat_names_the_phase_and_when_it_expects_to_be_done() -> None:
    trip = Trip()
    brief = trip.job.brief()
    light = PLANT.vehicle_types["light"]
    ways_s = ROUTES.duration_s("p3", "s3") + ROUTES.duration_s("s3", "m8")
    assert brief.due_s == pytest.approx(ways_s + light.load_s + light.unload_s)
    assert (brief.role, brief.phase, brief.quantity) == (Role.PRIMARY, Phase.APPROACHING, 40)
    trip.to_carrying()
    assert trip.job.brief().phase is Phase.CARRYING
    assert trip.job.brief().due_s == pytest.approx(
        trip.now_s + ROUTES.duration_s("s3", "m8") + light.unload_s
    )


# --- what is lost is said again, what is doubled is ignored -----------------------------------------


def test_the_question_for_the_dock_is_repeated_until_it_is_answered() -> None:
    trip = Trip().to_unloading()
    trip.waits()
    assert trip.now_s == ASK_AGAIN_S
    trip.waits()
    assert len(sent(trip.out, Docked, to="M8")) == 3
    trip.opened()
    assert trip.life.timers.next_s == NEVER_S


def test_a_held_dock_is_asked_for_again_later() -> None:
    trip = Trip().to_unloading()
    trip.held()
    trip.waits()
    assert trip.now_s == HELD_ASK_AGAIN_S
    assert len(sent(trip.out, Docked, to="M8")) == 2
    trip.opened()
    assert len(instructed(trip.out, Drop)) == 1


def test_the_handover_is_repeated_until_it_is_answered() -> None:
    trip = Trip().to_handing_over()
    trip.waits()
    trip.waits()
    assert sent(trip.out, Handover, to="M8") == [Handover(task="M8-1", epoch=1, quantity=40)] * 3


def test_a_dock_that_is_opened_twice_is_unloaded_at_once_only() -> None:
    trip = Trip().to_dropping()
    trip.opened()
    assert len(instructed(trip.out, Drop)) == 1


def test_an_opening_that_comes_too_late_is_ignored() -> None:
    trip = Trip().to_handing_over()
    trip.opened()
    trip.held()
    assert len(instructed(trip.out, Drop)) == 1


def test_an_opening_or_holding_of_another_station_is_ignored() -> None:
    trip = Trip().to_unloading()
    trip.opened("M7")
    trip.held("M7")
    assert instructed(trip.out, Drop) == []
    trip.waits()
    assert trip.now_s == ASK_AGAIN_S


def test_an_opening_on_the_way_is_ignored() -> None:
    trip = Trip().to_carrying()
    trip.opened()
    assert instructed(trip.out, Drop) == []


def test_an_acceptance_before_the_handover_is_ignored() -> None:
    trip = Trip().to_unloading()
    trip.hears(HandoverAccepted(task="M8-1", epoch=1))
    assert trip.job.ended is None


def test_the_end_of_an_older_action_is_ignored() -> None:
    trip = Trip().to_loading()
    trip.job.action_done(instructed(trip.out, Pick)[-1].order - 1, 0.0)
    trip.job.action_failed(instructed(trip.out, Pick)[-1].order - 1, "no contact", 0.0)
    assert trip.job.phase is Phase.LOADING
    trip.done(Pick)
    trip.done(Pick)
    assert trip.phases.count(Phase.CARRYING) == 1


# --- what fails is tried again ----------------------------------------------------------------------


def test_a_failed_pick_is_tried_again_after_a_while() -> None:
    trip = Trip().to_loading()
    trip.fails(Pick)
    assert len(instructed(trip.out, Pick)) == 1
    trip.waits()
    assert trip.now_s == RETRY_S
    trip.opened("S3")
    assert len(instructed(trip.out, Pick)) == 2


def test_a_failed_drop_asks_for_the_dock_again() -> None:
    trip = Trip().to_dropping()
    trip.fails(Drop)
    trip.waits()
    assert len(sent(trip.out, Docked, to="M8")) == 2
    assert len(instructed(trip.out, Drop)) == 1


def test_a_refused_way_is_asked_for_again_after_a_while() -> None:
    trip = Trip()
    trip.job.way_refused(0.0)
    trip.waits()
    assert trip.now_s == RETRY_S
    assert [way.nodes[-1] for way in instructed(trip.out, Drive)] == ["s3", "s3"]
