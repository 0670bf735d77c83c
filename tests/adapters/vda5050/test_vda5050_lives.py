"""Holding, and restarts of agent, vehicle and broker (behaviours 17, 19 and 20 of docs/vehicles.md)."""

from __future__ import annotations

from random import Random
from typing import Any

import msgspec
import pytest
from vda_rig import FLOWING, PROFILE, Rig
from yard import HOLD, PICK, TO_CORNER, UNHOLD, drive

from dray.adapters.vda5050.events import Memory
from dray.adapters.vda5050.profile import Profile
from dray.body import (
    ActionDone,
    ActionFailed,
    Drive,
    NodePassed,
    ProblemCleared,
    ReleaseWay,
    UnplacedVehicle,
    VehicleState,
    WayDone,
)
from dray_sim.vda5050.misbehaviour import Misbehaviour

NO_PAUSE = msgspec.structs.replace(PROFILE, pause=False)


@pytest.mark.parametrize("profile", [PROFILE, FLOWING, NO_PAUSE], ids=["steps", "updates", "without pause"])
def test_17_what_is_held_stands_and_goes_on_when_it_may(profile: Profile) -> None:
    rig = Rig(profile)
    rig.do(drive(*TO_CORNER), for_s=6.0)
    rig.do(HOLD, for_s=10.0)
    before = rig.sim.sense()
    assert before.speed_mps == 0.0
    assert rig.body.sense().held
    rig.run(60.0)
    assert rig.sim.sense().pose == before.pose
    rig.do(UNHOLD, for_s=150.0)
    assert rig.heard[-1] == WayDone(order=1, node="corner")
    assert [report.index for report in rig.of(NodePassed)] == [0, 1, 2, 3, 4]
    assert rig.problems() == []


def test_17_a_vehicle_that_moves_although_it_is_held_is_a_problem() -> None:
    rig = Rig(FLOWING, Misbehaviour(ignores_pause=True))
    rig.do(drive(*TO_CORNER), for_s=6.0)
    rig.do(HOLD, for_s=8.0)
    assert rig.problems() == ["it does not pause: it moves although it was told to stand"]
    rig.run(60.0)  # To the end of its base, and no farther.
    assert rig.heard[-1] == ProblemCleared()
    assert rig.sim.sense().node != "corner"


def test_17_a_pause_that_is_lost_is_said_again() -> None:
    rig = Rig()
    rig.do(drive(*TO_CORNER), for_s=3.0)
    rig.vehicle._ignored["instantActions"] = 1
    rig.do(HOLD, for_s=10.0)
    assert rig.sim.sense().held
    assert len(rig.instant("startPause")) == 2


def test_17_a_new_life_knows_that_it_is_held() -> None:
    rig = Rig()
    rig.do(drive(*TO_CORNER), for_s=3.0)
    rig.do(HOLD, for_s=5.0)
    rig.begin_life()
    rig.run(1.0)
    assert rig.body.sense().held
    rig.do(UNHOLD, for_s=60.0)
    assert not rig.sim.sense().held


@pytest.mark.parametrize("no_loads", [False, True])
@pytest.mark.parametrize("after_s", [0.0, 0.02, 0.5, 5.0, 9.9, 10.1, 20.0])
def test_19_a_new_life_never_picks_twice(after_s: float, no_loads: bool) -> None:
    rig = Rig(quirks=Misbehaviour(no_loads=no_loads))
    rig.run(1.0)
    rig.do(PICK, for_s=after_s)
    rig.begin_life()
    rig.run(1.0)
    heard = [] if rig.body.sense().load else rig.do(msgspec.structs.replace(PICK, order=1005), for_s=90.0)
    rig.run(90.0)
    assert rig.body.sense().load == "shaft"
    assert heard in ([], [ActionDone(order=1005)])
    assert len(rig.vehicle.done) == 1
    assert rig.problems() == []


def test_19_a_new_life_that_wants_nothing_still_learns_what_was_picked() -> None:
    rig = Rig(quirks=Misbehaviour(no_loads=True))
    rig.run(1.0)
    rig.do(PICK, for_s=2.0)
    rig.begin_life()
    rig.run(60.0)
    assert rig.body.sense().load == "shaft"
    assert rig.memory.load == "shaft"


@pytest.mark.parametrize("after_s", [0.0, 0.5, 4.0, 12.0])
def test_19_a_new_life_goes_on_with_its_running_way(after_s: float) -> None:
    rig = Rig()
    rig.do(drive(*TO_CORNER), for_s=after_s)
    rig.begin_life()
    rig.run(1.0)
    state = rig.body.sense()
    rest = TO_CORNER[TO_CORNER.index(state.next_node) :]
    rig.do(drive(*rest, order=1001), for_s=150.0)
    assert rig.heard[-1] == WayDone(order=1001, node="corner")
    assert rig.problems() == []


BOTH = pytest.mark.parametrize("profile", [PROFILE, FLOWING], ids=["steps", "updates"])


def late_orders(rig: Rig, late_s: float) -> None:
    """Orders come to the vehicle so late, as over a slow link: it has its states told meanwhile."""
    hear = rig.vehicle.on_message

    def arrive(topic: str, data: bytes) -> None:
        rig.clock.call_at(
            rig.clock.now_s() + (late_s if topic == "order" else 0.0), lambda: hear(topic, data)
        )

    rig.vehicle.on_message = arrive  # type: ignore[method-assign]


@BOTH
@pytest.mark.parametrize("late_s", [0.5, 4.0, 8.0])
def test_19_an_order_to_drive_that_comes_after_its_life_is_known_to_the_next(
    profile: Profile, late_s: float
) -> None:
    rig = Rig(profile)
    rig.run(1.0)
    late_orders(rig, late_s)
    rig.do(drive(*TO_CORNER))
    end = rig.orders()[-1]["nodes"][-1]["nodeId"]
    rig.begin_life()
    rig.run(0.2)
    state = rig.body.sense()
    assert isinstance(state, VehicleState)
    assert (state.node, state.next_node, state.base_end) == ("west", "middle", end)
    assert state.speed_mps == 0.0
    rig.heard.clear()
    rig.do(drive("middle", order=1001), for_s=late_s)
    rig.do(for_s=6.0)
    assert rig.heard == []
    assert rig.body.sense().base_end == end
    assert len(rig.orders()) == 1
    rig.run(60.0)
    assert rig.sim.sense().node == end
    assert rig.body.sense().base_end == ""
    assert [type(report) for report in rig.heard] == (
        [NodePassed, WayDone] if end == "middle" else [ActionFailed]
    )


@pytest.mark.parametrize("knows", ["nothing", "another order"])
def test_19_a_base_that_the_vehicle_shows_is_known_to_a_life_that_does_not_know_its_order(knows: str) -> None:
    """The journal is lost, or the order was taken for refused and came late."""
    rig = Rig(FLOWING)
    rig.do(drive(*TO_CORNER), for_s=3.0)
    end = rig.orders()[-1]["nodes"][-1]["nodeId"]
    assert end not in ("west", "middle")
    order = rig.memory.order
    assert order is not None
    another = msgspec.structs.replace(order, id="ATV1-1-99", nodes=order.nodes[:2], is_shown=False)
    rig.memory = Memory(order=another if knows == "another order" else None)
    rig.begin_life()
    rig.run(0.5)
    state = rig.body.sense()
    assert isinstance(state, VehicleState)
    assert (state.node, state.next_node, state.base_end) == ("west", "middle", end)
    rig.heard.clear()
    rig.do(drive("middle", order=1001))
    for _ in range(600):
        if rig.sim.sense().node == end:
            break
        assert (rig.heard, rig.body.sense().base_end) == ([], end)
        rig.run(0.1)
    rig.run(5.0)
    assert rig.body.sense().base_end == ""
    assert [type(report) for report in rig.heard] == [ActionFailed]


@pytest.mark.parametrize("what", ["lost", "restarted", "no instant actions are shown"])
def test_19_an_order_to_drive_that_never_comes_is_not_waited_for_for_ever(what: str) -> None:
    rig = Rig(quirks=Misbehaviour(ignores_instant_actions=1000 * (what == "no instant actions are shown")))
    rig.run(31.0)
    rig.vehicle._ignored["order"] = 1
    rig.do(drive(*TO_CORNER), for_s=0.1)
    rig.begin_life()
    rig.run(31.0 if what == "no instant actions are shown" else 0.5)
    assert rig.body.sense().base_end == "middle"
    rig.heard.clear()
    if what == "restarted":
        rig.vehicle.restart()
    rig.do(drive("middle", order=1001), for_s=45.0)
    assert rig.failures() == ["an order of an earlier life has not come to the vehicle"]
    state = rig.body.sense()
    assert (state.node, state.next_node, state.base_end) == ("west", "west", "")
    assert rig.memory.order is None
    rig.do(drive(*TO_CORNER, order=1002), for_s=150.0)
    assert rig.heard[-1] == WayDone(order=1002, node="corner")
    assert rig.problems() == []


def test_19_an_order_to_drive_is_waited_for_while_the_vehicle_is_silent_and_over_more_lives() -> None:
    rig = Rig()
    rig.run(1.0)
    late_orders(rig, 100.0)
    rig.do(drive(*TO_CORNER), for_s=0.1)
    rig.begin_life()
    rig.run(0.5)
    hear = rig.give
    rig.give = lambda topic, data: None  # type: ignore[method-assign]
    rig.run(60.0)
    assert rig.body.sense().base_end == "middle"
    rig.give = hear  # type: ignore[method-assign]
    rig.begin_life()
    rig.run(5.0)
    assert rig.body.sense().base_end == "middle"


def test_19_an_order_to_drive_is_not_waited_for_where_the_vehicle_would_not_take_it() -> None:
    rig = Rig(quirks=Misbehaviour(forgets_finished_order=True))
    rig.do(drive(*TO_CORNER), for_s=0.0)
    rig.body.end()  # The last life hears no more, and the vehicle drives.
    rig.run(30.0)
    assert rig.sim.sense().node == "middle"
    assert rig.memory.order is not None
    assert not rig.memory.order.is_shown
    rig.begin_life()
    rig.run(0.2)
    state = rig.body.sense()
    assert (state.node, state.next_node, state.base_end) == ("middle", "middle", "")
    rig.do(drive(*TO_CORNER[1:], order=1001), for_s=120.0)
    assert rig.heard[-1] == WayDone(order=1001, node="corner")


def test_19_an_update_that_comes_after_its_life_is_known_to_the_next() -> None:
    rig = Rig(FLOWING)
    rig.do(Drive(order=1, nodes=TO_CORNER, released=2), for_s=10.6)
    late_orders(rig, 8.0)
    rig.do(ReleaseWay(order=1, released=4), for_s=0.1)
    assert [order["orderUpdateId"] for order in rig.orders()] == [0, 1]
    rig.begin_life()
    rig.run(0.5)
    assert rig.body.sense().base_end == "north"
    rig.heard.clear()
    rig.do(drive("middle", order=1001), for_s=7.0)
    assert rig.sim.sense().node == "middle"
    assert rig.sim.sense().speed_mps == 0.0
    assert rig.body.sense().base_end == "north"
    assert rig.heard == []
    rig.run(60.0)
    assert rig.sim.sense().node == "north"
    assert [type(report) for report in rig.heard] == [ActionFailed]


@BOTH
def test_19_no_node_of_a_way_is_passed_while_an_earlier_life_has_the_vehicle_drive_beyond(
    profile: Profile,
) -> None:
    rig = Rig(profile)
    rig.do(drive(*TO_CORNER), for_s=3.0)
    end = rig.orders()[-1]["nodes"][-1]["nodeId"]
    rig.begin_life()
    rig.run(1.0)
    assert rig.body.sense().base_end == end
    rig.heard.clear()
    rig.do(drive("middle", order=1001))
    for _ in range(300):
        if rig.body.sense().base_end != end:
            break
        assert rig.heard == []
        rig.run(0.1)
    assert rig.body.sense().base_end == ""
    assert rig.sim.sense().node == end
    rig.run(5.0)
    assert [type(report) for report in rig.heard] == (
        [NodePassed, WayDone] if end == "middle" else [ActionFailed]
    )


@BOTH
def test_20_a_vehicle_that_is_restarted_fails_its_way(profile: Profile) -> None:
    rig = Rig(profile)
    rig.do(drive(*TO_CORNER), for_s=15.0)
    rig.vehicle.restart()
    rig.run(15.0)
    assert rig.failures() == ["the vehicle has forgotten the order: it was restarted, or has another master"]
    state = rig.body.sense()
    rest = TO_CORNER[TO_CORNER.index(state.next_node) :]
    rig.do(drive(*rest, order=2), for_s=150.0)
    assert rig.heard[-1] == WayDone(order=2, node="corner")


@pytest.mark.parametrize("version", ["2.0", "2.1", "3.0"])
def test_20_a_vehicle_that_follows_lines_drives_its_lane_to_the_end_when_all_else_is_forgotten(
    version: Any,
) -> None:
    rig = Rig(msgspec.structs.replace(PROFILE, version=version), node="middle")
    rig.do(drive("middle", "east"), for_s=1.2)
    forget_all(rig)
    state = rig.body.sense()
    assert 10.05 < state.pose.x_m < 10.0 + PROFILE.node_m
    assert (state.node, state.next_node) == ("middle", "east")
    assert rig.said("state", "it")[-1]["distanceSinceLastNode"] == pytest.approx(state.pose.x_m - 10.0)
    rig.do(drive("middle", "pit", order=2), for_s=5.0)
    assert rig.failures() == ["the way must begin at east"]
    rig.do(drive("east", "middle", "pit", order=3), for_s=120.0)
    assert rig.heard[-1] == WayDone(order=3, node="pit")
    assert rig.said("state", "it")[-1]["distanceSinceLastNode"] == 0.0


@pytest.mark.parametrize(
    ("version", "kind"), [("2.0", "noRouteError"), ("2.1", "noRouteError"), ("3.0", "NO_ROUTE_TO_TARGET")]
)
def test_20_a_way_that_leaves_the_lane_is_refused_aloud(version: Any, kind: str) -> None:
    rig = Rig(msgspec.structs.replace(PROFILE, version=version), node="middle")
    rig.do(drive("middle", "east"), for_s=0.4)
    forget_all(rig)
    assert rig.body.sense().next_node == "middle", "so near that it is thought to be there still"
    rig.do(drive("middle", "pit", order=2), for_s=15.0)
    assert rig.failures() == [f"{kind}: the way must begin at east"]
    state = rig.said("state", "it")[-1]
    error = state["errors"][-1]
    assert (error["errorType"], state["nodeStates"], state["driving"]) == (kind, [], False)
    assert {"referenceKey": "orderId", "referenceValue": rig.orders()[-1]["orderId"]} in error[
        "errorReferences"
    ]
    assert rig.problems() == []
    assert rig.body.sense().next_node == "east", "now it is known that it has left"
    rig.do(drive("east", "middle", "pit", order=3), for_s=120.0)
    assert rig.heard[-1] == WayDone(order=3, node="pit")


def test_20_a_horizon_that_is_left_of_a_forgotten_order_is_cancelled() -> None:
    rig = Rig(msgspec.structs.replace(FLOWING, version="3.0", horizon=2))
    rig.do(Drive(order=1, nodes=TO_CORNER, released=2), for_s=30.0)
    assert rig.said("state", "it")[-1]["nodeStates"]
    rig.memory = Memory()
    rig.begin_life()
    rig.run(1.0)
    rig.do(drive("middle", "pit", order=1001), for_s=90.0)
    assert rig.heard[-1] == WayDone(order=1001, node="pit")
    assert len(rig.instant("cancelOrder")) == 1


def forget_all(rig: Rig) -> None:
    """The vehicle loses its power where it is, and its agent its memory."""
    rig.vehicle.restart()
    rig.memory = Memory()
    rig.begin_life()
    rig.run(1.0)
    rig.heard.clear()


def test_20_what_is_on_board_after_a_restart_is_asked() -> None:
    rig = Rig()
    rig.run(1.0)
    rig.do(PICK, for_s=4.0)
    rig.vehicle.restart()
    rig.run(15.0)
    assert [type(report) for report in rig.heard] == [ActionFailed]
    assert rig.body.sense().load == ""
    late = Rig()
    late.run(1.0)
    late.do(PICK, for_s=9.0)
    late.is_up = False
    late.run(30.0)
    assert late.sim.sense().load == "shaft"
    late.is_up = True
    late.vehicle.restart()
    late.run(15.0)
    assert late.heard == [ActionDone(order=5)]
    assert late.body.sense().load == "shaft"


def test_20_what_a_vehicle_cannot_tell_people_are_asked() -> None:
    rig = Rig(quirks=Misbehaviour(no_loads=True))
    rig.run(1.0)
    rig.do(PICK, for_s=4.0)
    rig.vehicle.restart()
    rig.run(15.0)
    assert rig.problems() == [
        "nobody saw the end of its pick: see what is on board, and switch it to MANUAL and back"
    ]
    assert rig.do(msgspec.structs.replace(PICK, order=6), for_s=30.0) == []
    rig.begin_life()
    rig.run(5.0)
    assert rig.body.sense().problem == rig.problems()[0]
    for mode in ("SERVICE", "AUTOMATIC"):
        rig.vehicle.condition.mode = mode
        rig.vehicle.say_state()
        rig.run(1.0)
    assert rig.body.sense().problem == ""
    assert rig.do(msgspec.structs.replace(PICK, order=7), for_s=60.0)[-1] == ActionDone(order=7)


def test_a_broker_that_is_away_is_a_problem_with_a_name_and_the_base_is_driven_to_its_end() -> None:
    rig = Rig()
    rig.do(drive(*TO_CORNER), for_s=3.0)
    rig.cut()
    rig.run(60.0)
    assert rig.problems() == ["the broker is away: refused"]
    assert rig.sim.sense().node == "middle"
    rig.link()
    rig.run(150.0)
    assert rig.heard[-1] == WayDone(order=1, node="corner")
    assert [report.index for report in rig.of(NodePassed)] == [0, 1, 2, 3, 4]


PROFILES = (PROFILE, FLOWING, msgspec.structs.replace(FLOWING, horizon=2, version="3.0"), NO_PAUSE)


@pytest.mark.parametrize("seed", range(24))
def test_restarts_losses_and_reordering_in_any_order_lose_nothing_and_do_nothing_twice(seed: int) -> None:
    """A load is fetched and brought, whatever happens on the way; an agent of few words asks again for what has failed."""
    chance = Random(seed)
    rig = Rig(PROFILES[seed % len(PROFILES)])
    rig.run(1.0)
    unreliable(rig, chance)
    agent = Agent(rig)
    for moment in range(400):
        if moment < 300 and chance.random() < 0.03:
            chance.choice(
                (rig.vehicle.restart, rig.begin_life, lambda: cut_for(rig, chance.uniform(1.0, 12.0)))
            )()
        agent.step()
        rig.run(1.0)
        if agent.is_done:
            break
    assert agent.is_done, (seed, rig.heard[-5:], rig.problems()[-3:], rig.body.sense())
    assert len(rig.vehicle.done) == 1
    assert rig.sim.sense().load_quantity == 20


def cut_for(rig: Rig, for_s: float) -> None:
    rig.cut()
    rig.clock.call_at(rig.clock.now_s() + for_s, rig.link)


def unreliable(rig: Rig, chance: Random) -> None:
    """Every tenth message is lost, others are doubled, late or spoilt, in both directions."""
    to_us, to_it = rig.body.on_message, rig.vehicle.on_message

    def arrive(is_ours: bool, topic: str, data: bytes) -> None:
        if rig.is_up:
            (rig.body.on_message if is_ours else to_it)(topic, data)

    def spoil(topic: str, data: bytes, hear: object) -> None:
        draw = chance.random()
        if draw < 0.08:
            return
        if draw < 0.12 and hear is to_us:
            data = data[: len(data) // 2]
        for late_s in (0.0, 0.3) if draw < 0.2 else (chance.uniform(0.0, 0.4),):
            rig.clock.call_at(rig.clock.now_s() + late_s, arrive, hear is to_us, topic, data)

    rig.give = lambda topic, data: spoil(topic, data, to_us)  # type: ignore[method-assign]
    rig.vehicle.on_message = lambda topic, data: spoil(topic, data, to_it)  # type: ignore[method-assign]


class Agent:
    """Fetches a load at west and brings it to north; knows only what the body senses and reports."""

    def __init__(self, rig: Rig) -> None:
        self.rig, self.order, self.seen = rig, 100, 0
        self.waits, self.lives = False, rig.lives
        self.is_done = False

    def step(self) -> None:
        rig = self.rig
        new, self.seen = rig.heard[self.seen :], len(rig.heard)
        over = [report for report in new if isinstance(report, WayDone | ActionDone | ActionFailed)]
        if self.lives != rig.lives or any(report.order == self.order for report in over):
            self.waits, self.lives = False, rig.lives
        if self.waits or not rig.body.control.is_known:
            return
        state = rig.body.sense()
        if state.problem:
            return
        self.order += 1
        self.waits = True
        self._next(state)

    def _next(self, state: VehicleState) -> None:
        rig, goal = self.rig, "north" if self.order_is_loaded(state) else "west"
        stands = state.next_node == state.node
        if self.order_is_loaded(state) and stands and state.node == "north":
            self.is_done = True
        elif not self.order_is_loaded(state) and stands and state.node == "west":
            rig.body.instruct(msgspec.structs.replace(PICK, order=self.order))
        else:
            line = TO_CORNER
            here, there = line.index(state.next_node), line.index(goal)
            nodes = line[here : there + 1] if here <= there else tuple(reversed(line[there : here + 1]))
            rig.body.instruct(Drive(order=self.order, nodes=nodes, released=len(nodes)))

    def order_is_loaded(self, state: VehicleState) -> bool:
        return state.load == "shaft"


def test_a_vehicle_that_has_not_told_a_place_has_a_state_that_says_what_is_missing() -> None:
    rig = Rig(linked=False)
    assert rig.body.sense() == UnplacedVehicle("the broker has not answered yet")
    rig.link()
    assert rig.body.sense() == UnplacedVehicle("the vehicle has not said anything yet")
    assert not rig.body.placed.is_set()
    rig.run(1.0)
    assert isinstance(rig.body.sense(), VehicleState)
    assert rig.body.placed.is_set()
