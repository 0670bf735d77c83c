"""Nobody waits for ever: who stands for long becomes more urgent, and who makes room in vain goes elsewhere next."""

from __future__ import annotations

import pytest
from rights_of_way import right_of_way, surroundings_of

from dray.messages.floor.traffic import (
    Blocked,
    FloorReported,
    HoldsAsked,
    OnFloor,
    PlaceConfirmed,
    PlaceGranted,
    PlaceRequested,
    PlaceReservation,
    YieldAsked,
    YieldRefused,
)
from dray.plant import load_plant
from dray.protocol.runtime.events import Send
from dray.protocol.runtime.life import Life
from dray.protocol.traffic.driving.right_of_way import HELD_UP, IDLE, WITH_TASK, Errand
from dray.protocol.traffic.driving.wait import AGES_BY_S, AGES_EVERY_S, SHUT_OUT_S
from dray.protocol.traffic.traffic_map import TrafficMap

PLANT = load_plant("single-track")
TRAFFIC = TrafficMap(PLANT)
HERE, GOAL = "b3", "m8-lane"
BEGUN_S = 1000.0


class Waiting:
    """A's right of way on a leg that is blocked from its first lane on."""

    def __init__(self, blocked: Blocked, here: str = HERE, goal: str = GOAL) -> None:
        self.life = Life()
        self.out = self.life.effects
        self.here = here
        self.surroundings = surroundings_of(PLANT, TRAFFIC, self.life)
        self.row = right_of_way(PLANT, TRAFFIC, self.life, here, surroundings=self.surroundings)
        self.number = 0
        self.row.start(BEGUN_S)
        self.answer(Blocked.NO, BEGUN_S, here)
        self.row.go(goal, WITH_TASK, BEGUN_S)
        self.answer(blocked, BEGUN_S)

    def request(self) -> PlaceRequested:
        """Its newest one."""
        return [
            e.message
            for e in self.life.effects
            if isinstance(e, Send) and isinstance(e.message, PlaceRequested)
        ][-1]

    def answer(self, blocked: Blocked, now_s: float, *places: str) -> None:
        """The table answers the newest request."""
        request = self.request()
        self.number += 1
        at = request.groups[0][0] if blocked is not Blocked.NO else ""
        granted = PlaceGranted(
            district=request.district,
            epoch=0,
            life=1,
            upto=request.seq,
            grants=tuple(
                PlaceReservation(place=place, number=self.number) for place in places or (self.here,)
            ),
            blocked=blocked,
            by="B" if at else "",
            at=at,
        )
        replica, copy = TRAFFIC.places.replicas_of[request.district][:2]
        confirmed = PlaceConfirmed(district=request.district, epoch=0, grants=granted.grants)
        self.row.on_confirmed(copy, confirmed, now_s)
        self.row.on_granted(replica, granted, now_s)
        self.row.on_holds_asked(copy, HoldsAsked(district=request.district, epoch=0), now_s)

    def drive_on(self, granted_s: float, reached_s: float) -> None:
        """The table grants what it wants, and it drives there."""
        wanted = {place for group in self.request().groups for place in group}
        self.answer(Blocked.NO, granted_s, *self.row.holds, *sorted(wanted - {*self.row.holds}))
        while not self.row.way.stands:
            self.row.on_passed(reached_s)

    def drive_to_refuge(self, granted_s: float, reached_s: float) -> None:
        """It reaches its refuge."""
        refuge = self.row.way.goal
        for _ in self.row.way.ahead:
            self.drive_on(granted_s, reached_s)
        assert (self.row.errand, self.row.way.node) == (Errand.REST, refuge)

    def wait(self, until_s: float) -> None:
        """Let its alarms come."""
        while self.life.timers.next_s <= until_s:
            now_s = self.life.timers.next_s
            for name in self.life.timers.due(now_s):
                if name == HELD_UP:
                    self.row.reroute(now_s)


@pytest.mark.parametrize(("blocked", "ages"), [(Blocked.WAIT, True), (Blocked.DOCKED, False)])
def test_who_is_held_up_for_long_becomes_more_urgent_but_not_than_work_at_a_dock(
    blocked: Blocked, *, ages: bool
) -> None:
    vehicle = Waiting(blocked)
    vehicle.wait(BEGUN_S + AGES_EVERY_S - 1.0)
    assert vehicle.request().rank == (WITH_TASK, BEGUN_S, "A")
    vehicle.wait(BEGUN_S + 2.0 * AGES_EVERY_S - 1.0)
    assert vehicle.row.own_rank == (WITH_TASK, BEGUN_S - ages * AGES_BY_S, "A")
    assert vehicle.request().rank == vehicle.row.own_rank
    vehicle.row.go(GOAL, WITH_TASK, BEGUN_S + 100.0)
    assert vehicle.row.own_rank[1] == BEGUN_S + 100.0, "another leg begins anew"


def test_who_made_room_in_vain_for_one_that_has_nowhere_to_go_goes_elsewhere_next() -> None:
    vehicle = Waiting(Blocked.WAIT)
    ends = []
    for _ in range(3):
        vehicle.row.errand = Errand.OWN
        vehicle.row.on_yield_refused("B", YieldRefused(avoid=(), holds=()), BEGUN_S + 1.0)
        assert vehicle.row.errand is Errand.REFUGE
        ends.append(vehicle.row.way.goal)
    assert len({*ends, HERE}) == 4


def test_who_waits_long_for_a_silent_vehicle_is_shut_out_by_it_wherever_lanes_lead_to_its_place() -> None:
    vehicle = Waiting(Blocked.SILENT)
    at = vehicle.request().groups[0][0]
    vehicle.wait(BEGUN_S + SHUT_OUT_S)
    assert vehicle.row.shut_out(BEGUN_S + SHUT_OUT_S - 1.0) is None
    shut = vehicle.row.shut_out(BEGUN_S + SHUT_OUT_S)
    assert shut is not None
    assert (shut.by, shut.waited_s) == ("B", SHUT_OUT_S)
    assert shut.lanes[0][0] == HERE
    assert set(shut.lanes) == set(TRAFFIC.places.entries(at))


def test_time_spent_waiting_for_one_that_lives_does_not_count_as_waiting_for_a_silent_one() -> None:
    vehicle = Waiting(Blocked.WAIT)
    vehicle.wait(BEGUN_S + SHUT_OUT_S)
    assert vehicle.row.shut_out(BEGUN_S + SHUT_OUT_S) is None
    vehicle.answer(Blocked.SILENT, BEGUN_S + SHUT_OUT_S)
    assert vehicle.row.shut_out(BEGUN_S + 2.0 * SHUT_OUT_S - 1.0) is None
    assert vehicle.row.shut_out(BEGUN_S + 2.0 * SHUT_OUT_S) is not None


def test_who_rests_makes_room_for_one_that_begins_to_look_for_a_place_to_rest() -> None:
    vehicle = Waiting(Blocked.NO)
    vehicle.row.rest(BEGUN_S)
    district = TRAFFIC.places.district_of[HERE]
    asked = YieldAsked(
        district=district, waiting="B", rank=(IDLE, BEGUN_S + 1000.0, "B"), avoid=(HERE, GOAL), chain=()
    )
    vehicle.row.on_yield_asked(TRAFFIC.places.replicas_of[district][0], asked, BEGUN_S + 1001.0)
    assert vehicle.row.errand is Errand.REFUGE
    assert vehicle.row.way.goal not in (HERE, GOAL)


def test_who_has_no_way_out_but_past_the_one_that_asks_wants_that_way_until_it_has_backed_off() -> None:
    dock, mouth = "m4", "m4-lane"
    vehicle = Waiting(Blocked.NO, dock, dock)
    vehicle.row.rest(BEGUN_S)
    district = TRAFFIC.places.district_of[dock]
    replica = TRAFFIC.places.replicas_of[district][0]
    rank = (WITH_TASK, BEGUN_S - 1.0, "B")
    other = OnFloor(
        atv="B", holds=(mouth,), stands=True, docked=False, silent=False, rank=rank, route=(mouth, dock)
    )
    told = FloorReported(district=district, epoch=0, number=1, vehicles=(other,))
    vehicle.surroundings.on_floor(replica, told, BEGUN_S)
    asked = YieldAsked(district=district, waiting="B", rank=rank, avoid=(mouth, dock), chain=())
    vehicle.row.on_yield_asked(replica, asked, BEGUN_S + 1.0)
    [refused] = [
        e.message for e in vehicle.out if isinstance(e, Send) and isinstance(e.message, YieldRefused)
    ]
    assert refused.avoid[:2] == (dock, mouth)
    refuge = refused.avoid[-1]
    assert refuge not in (dock, mouth), "B is not to back off there"
    assert vehicle.request().groups == ((mouth,),)
    assert vehicle.request().rank == rank
    vehicle.drive_to_refuge(BEGUN_S + 3.0, BEGUN_S + 5.0)
    assert vehicle.row.way.node == refuge
