"""A committed transport, as its carrier lives it."""

from __future__ import annotations

from typing import Any

import pytest
from kit import PLANT, facts, instructed, sent, transport

from dray.body import Drive, Drop, Pick, VehicleState, WayDone
from dray.memory import Contract
from dray.messages import (
    Docked,
    DockHeld,
    DockOpened,
    Handover,
    HandoverAccepted,
    Message,
    Phase,
    Pose,
    Resigned,
    Role,
    Superseded,
    Withdrawn,
)
from dray.messages.fact import PhaseEntered
from dray.protocol.runtime.events import NEVER_S, Effect
from dray.protocol.runtime.retransmission import ASK_AGAIN_S
from dray.protocol.runtime.timers import Timers
from dray.protocol.vehicle.driving import Driver
from dray.protocol.vehicle.transport_job import (
    GIVE_UP_AFTER,
    HELD_ASK_AGAIN_S,
    RETRY_S,
    TRIES,
    WAITS_AT_LEAST_S,
    TransportJob,
)

ROUTES = PLANT.routes("light")


GOODS: dict[str, Any] = {
    "item": "pump-p3",
    "quantity": 24,
    "sources": ("M8",),
    "destination": "DELIVERY",
    "goal": "G8",
}


class Trip:
    """A job, the vehicle under it and the time."""

    def __init__(self, node: str = "p3", source: str = "S3", **changes: Any) -> None:
        self.out: list[Effect] = []
        self.now_s = 0.0
        self.timers = Timers()
        self.driver = Driver(PLANT, "light", self.out)
        spot = PLANT.nodes[node]
        state = VehicleState(
            pose=Pose(x_m=spot.x_m, y_m=spot.y_m, heading_rad=0.0),
            node=node,
            next_node=node,
            next_node_s=0.0,
            speed_mps=0.0,
            battery_frac=0.9,
            load="",
            load_quantity=0,
            held=False,
            charging=False,
        )
        self.driver.sense(state)
        self.job = TransportJob(
            "ATV1",
            Contract(
                task="M8-1",
                epoch=1,
                work=transport(**changes),
                coordinator="M8",
                source=source,
                promised_s=100.0,
                deadline_s=300.0,
            ),
            plant=PLANT,
            vehicle_type="light",
            driver=self.driver,
            timers=self.timers,
            out=self.out,
        )
        self.load = ""
        self.job.begin(0.0)

    @property
    def phases(self) -> list[Phase]:
        return [fact.phase for fact in facts(self.out, PhaseEntered)]

    def arrives(self, *, opens: bool = True) -> None:
        """The newest way is driven; a storage lets the vehicle load at once, unless the test answers for it."""
        way = instructed(self.out, Drive)[-1]
        self.driver.on_done(WayDone(order=way.order, node=way.nodes[-1]))
        self.job.arrived(self.now_s)
        source = self.job.source
        if opens and self.job.phase is Phase.LOADING and source in PLANT.storages:
            self.opened(source)

    def hears(self, message: Message) -> None:
        self.job.on_answer(message, self.now_s)

    def opened(self, station: str = "M8") -> None:
        self.hears(DockOpened(task="M8-1", epoch=1, station=station))

    def held(self, station: str = "M8") -> None:
        self.hears(DockHeld(task="M8-1", epoch=1, station=station, reason="the buffer is full"))

    def superseded(self) -> None:
        self.hears(Superseded(task="M8-1", epoch=2))

    def done(self, kind: type[Pick | Drop]) -> None:
        self.load = self.job.work.item if kind is Pick else ""
        self.job.action_done(instructed(self.out, kind)[-1].order, self.now_s)

    def fails(self, kind: type[Pick | Drop]) -> None:
        self.job.action_failed(instructed(self.out, kind)[-1].order, "no contact", self.now_s)

    def waits(self) -> None:
        """Until the alarm."""
        assert self.timers.next_s < NEVER_S
        self.now_s = self.timers.next_s
        for _ in self.timers.due(self.now_s):
            self.job.wake(self.load, self.now_s)

    def to_loading(self) -> Trip:
        self.arrives()
        return self

    def to_carrying(self) -> Trip:
        self.to_loading().done(Pick)
        return self

    def to_unloading(self) -> Trip:
        self.to_carrying().arrives()
        return self

    def to_dropping(self) -> Trip:
        self.to_unloading().opened()
        return self

    def to_handing_over(self) -> Trip:
        self.to_dropping().done(Drop)
        return self


# --- the straight way ----------------------------------------------------------------------------


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
    assert trip.job.ended == "handed_over"
    assert trip.timers.next_s == NEVER_S


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
    assert (resigned.short, resigned.reason) == ("S3", "the buffer is full")
    trip.hears(Withdrawn(task="M8-1", epoch=1, reason="not needed any more"))
    assert trip.job.ended == "the buffer is full"


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
    assert (resigned.short, resigned.reason) == ("S3", "S3 does not answer")


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
        "ATV1",
        trip.job.memory(),
        plant=PLANT,
        vehicle_type="light",
        driver=trip.driver,
        timers=trip.timers,
        out=trip.out,
    )
    trip.job.resume("pump-p3", trip.now_s)
    trip.fails(Drop)
    assert [said.reason for said in sent(trip.out, Resigned)] == ["refused: no contact"]


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


# --- what is lost is said again, what is doubled is ignored --------------------------------------


def test_the_question_for_the_dock_is_repeated_until_it_is_answered() -> None:
    trip = Trip().to_unloading()
    trip.waits()
    assert trip.now_s == ASK_AGAIN_S
    trip.waits()
    assert len(sent(trip.out, Docked, to="M8")) == 3
    trip.opened()
    assert trip.timers.next_s == NEVER_S


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
    assert trip.job.ended == ""


def test_the_end_of_an_older_action_is_ignored() -> None:
    trip = Trip().to_loading()
    trip.job.action_done(instructed(trip.out, Pick)[-1].order - 1, 0.0)
    trip.job.action_failed(instructed(trip.out, Pick)[-1].order - 1, "no contact", 0.0)
    assert trip.job.phase is Phase.LOADING
    trip.done(Pick)
    trip.done(Pick)
    assert trip.phases.count(Phase.CARRYING) == 1


# --- what fails is tried again -------------------------------------------------------------------


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


# --- when the contract is void -------------------------------------------------------------------


@pytest.mark.parametrize(
    ("message", "reason"),
    [
        (Superseded(task="M8-1", epoch=2), "superseded"),
        (Withdrawn(task="M8-1", epoch=1, reason="not needed any more"), "withdrawn"),
    ],
)
def test_without_a_load_a_void_contract_just_ends(message: Message, reason: str) -> None:
    trip = Trip()
    trip.hears(message)
    assert trip.job.ended == reason
    assert trip.timers.next_s == NEVER_S


def test_a_superseded_primary_returns_its_load_to_the_nearest_storage_that_keeps_it() -> None:
    trip = Trip().to_carrying()
    trip.superseded()
    assert trip.job.phase is Phase.RETURNING
    assert trip.job.ended == ""
    here = trip.driver.next_node
    keeping = PLANT.storages_of("shaft")
    nearest = min(keeping, key=lambda each: ROUTES.duration_s(here, PLANT.node_of(each)))
    assert instructed(trip.out, Drive)[-1].nodes[-1] == PLANT.node_of(nearest)
    trip.arrives()
    assert instructed(trip.out, Drop)[-1].station == nearest
    trip.done(Drop)
    assert trip.job.ended == "superseded"


def test_a_superseded_primary_at_the_dock_puts_nothing_down_there() -> None:
    trip = Trip().to_unloading()
    trip.superseded()
    assert trip.job.phase is Phase.RETURNING
    trip.opened()
    assert instructed(trip.out, Drop) == []


def test_a_contract_that_is_void_while_it_loads_ends_after_the_load_is_back() -> None:
    trip = Trip().to_loading()
    trip.superseded()
    assert trip.job.ended == ""
    trip.done(Pick)
    assert trip.job.phase is Phase.RETURNING
    trip.arrives() if not instructed(trip.out, Drop) else None
    trip.done(Drop)
    assert trip.job.ended == "superseded"


def test_a_contract_that_is_void_while_a_pick_fails_ends() -> None:
    trip = Trip().to_loading()
    trip.superseded()
    trip.fails(Pick)
    assert trip.job.ended == "superseded"


def test_a_contract_that_is_void_while_a_drop_fails_ends_after_the_load_is_back() -> None:
    trip = Trip().to_dropping()
    trip.superseded()
    trip.fails(Drop)
    assert trip.job.phase is Phase.RETURNING
    trip.arrives()
    trip.done(Drop)
    assert trip.job.ended == "superseded"


def test_a_contract_that_is_void_while_it_unloads_ends_without_a_handover() -> None:
    trip = Trip().to_dropping()
    trip.superseded()
    assert trip.job.ended == ""
    trip.done(Drop)
    assert trip.job.ended == "superseded"
    assert sent(trip.out, Handover) == []
    assert trip.timers.next_s == NEVER_S


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
    assert trip.job.ended == "superseded"


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
    assert trip.job.ended == "superseded"


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
    assert trip.job.ended == "superseded"


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
    assert trip.job.ended == "superseded"


def test_a_contract_becomes_void_once() -> None:
    trip = Trip().to_carrying()
    trip.superseded()
    trip.superseded()
    trip.hears(Withdrawn(task="M8-1", epoch=1, reason="not needed any more"))
    assert trip.phases.count(Phase.RETURNING) == 1
    trip.arrives()
    trip.done(Drop)
    assert trip.job.ended == "superseded"


def test_a_refused_way_back_is_asked_for_again() -> None:
    trip = Trip().to_carrying()
    trip.superseded()
    goal = instructed(trip.out, Drive)[-1].nodes[-1]
    trip.job.way_refused(0.0)
    trip.waits()
    assert instructed(trip.out, Drive)[-1].nodes[-1] == goal
