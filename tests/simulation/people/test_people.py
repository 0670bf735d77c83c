"""Operators: what they notice, in which order they act, and what they do with their hands."""

from __future__ import annotations

import asyncio
from collections import Counter
from collections.abc import Callable, Coroutine
from dataclasses import replace
from random import Random

import pytest

from dray.adapters.security.signing import SigningKey
from dray.messages import (
    AtvHeartbeat,
    AtvStatus,
    Brief,
    CommandAnswered,
    CommandKind,
    HelpWanted,
    Message,
    Phase,
    Pose,
    Role,
    VehicleCommand,
)
from dray.plant import default_plant
from dray_sim.bodies.condition import BATTERY_EMPTY
from dray_sim.bodies.vehicle import LOAD_SHIFTED
from dray_sim.checks.invariants import Invariants
from dray_sim.clock.loop import clock, run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.faults import Faults, LinkTrouble
from dray_sim.network.listeners import Listeners
from dray_sim.network.sim_network import SimNetwork
from dray_sim.people import demand
from dray_sim.people.desk import Desk
from dray_sim.people.habits import Habits
from dray_sim.people.hands import Hands
from dray_sim.people.operators import LOOK_S, Duty, Operator, area_at, hire
from dray_sim.people.tablet import ANSWER_S, TRIES

PLANT = default_plant()
AUTHORITY = SigningKey(bytes(32))
QUICK = Habits(
    react_s=(1.0, 1.0),
    walk_s=(10.0, 10.0),
    mend_s=(20.0, 20.0),
    carry_s=(5.0, 5.0),
    push_s=(5.0, 5.0),
    estimate=(1.0, 1.0),
    slow_frac=1.0,
)
"""Nothing of chance."""

NORTH, SOUTH = Pose(x_m=30.0, y_m=30.0, heading_rad=0.0), Pose(x_m=30.0, y_m=2.0, heading_rad=0.0)
BEYOND = Pose(x_m=30.0, y_m=25.5, heading_rad=0.0)
"""Just outside of AREA1, in AREA2."""


class Puppet:
    """A vehicle that says what the test wants, beats once a second, and answers as it is told.

    Attributes:
        status, problem, help, pose: for the heartbeats.
        silent: says nothing at all.
        deaf: so many of the next commands are not heard.
        refuses: kinds that are refused.
        heard: every command that reached it, repeated ones too, with the time.
        obeyed: who gave those that were done, and their kinds.
    """

    def __init__(self, bus: SimNetwork, atv: str = "ATV1") -> None:
        self.atv = atv
        self.status, self.problem, self.pose = AtvStatus.WORKING, "", NORTH
        self.help: HelpWanted | None = None
        self.task: Brief | None = None
        self.silent, self.deaf = False, 0
        self.refuses: set[CommandKind] = set()
        self.heard: list[tuple[float, VehicleCommand]] = []
        self.obeyed: list[tuple[str, CommandKind]] = []
        self._session = bus.join(atv, self._on_message)

    @property
    def kinds(self) -> list[CommandKind]:
        """What was asked, each command once."""
        return [command.kind for command in {command.command: command for _, command in self.heard}.values()]

    async def run(self) -> None:
        seq = 0
        while True:
            seq += 1
            if not self.silent:
                self._session.publish(f"{PLANT.id}/hb/atv/{self.atv}", self._heartbeat(seq))
            await asyncio.sleep(1.0)

    def _heartbeat(self, seq: int) -> AtvHeartbeat:
        return AtvHeartbeat(
            atv=self.atv,
            incarnation=1,
            seq=seq,
            at_s=clock().now_s(),
            status=self.status,
            pose=self.pose,
            node="n1",
            speed_mps=0.0,
            battery_frac=0.5,
            task=self.task,
            problem=self.problem,
            help=self.help,
        )

    def _on_message(self, sender: str, message: Message) -> None:
        if not isinstance(message, VehicleCommand) or self.silent:
            return
        self.heard.append((clock().now_s(), message))
        if self.deaf > 0:
            self.deaf -= 1
            return
        done = message.kind not in self.refuses and self._is_covered(message)
        if done:
            self.obeyed.append((sender, message.kind))
        if done and message.kind is CommandKind.STOP:
            self.status = AtvStatus.STOPPED
        elif done and message.kind is CommandKind.RESUME:
            self.status = AtvStatus.WORKING
        self._session.send(sender, CommandAnswered(command=message.command, done=done))

    def _is_covered(self, command: VehicleCommand) -> bool:
        near = PLANT.areas_near(self.pose.x_m, self.pose.y_m, command.kind.margin_m)
        return command.grant is not None and not set(near).isdisjoint(command.grant.areas)


class FakeHands:
    """Notes what is done, and when."""

    def __init__(self, puppet: Puppet) -> None:
        self.puppet = puppet
        self.off = False
        self.load = ("", 0)
        self.deeds: list[tuple[str, float]] = []
        self.put: tuple[object, ...] = ()

    def problem(self, _atv: str) -> str:
        return self.puppet.problem

    def is_off(self, _atv: str) -> bool:
        return self.off

    def mend(self, _atv: str) -> None:
        self._note("mend")
        self.puppet.problem, self.puppet.help = "", None
        if self.puppet.status is AtvStatus.ERROR:
            self.puppet.status = AtvStatus.WORKING

    def unload(self, _atv: str) -> tuple[str, int]:
        self._note("unload")
        return self.load

    def put_down(self, *load: object) -> str:
        self._note("put down")
        self.put = load
        return "S1"

    def bring_home(self, _atv: str) -> str:
        self._note("bring home")
        self.off = self.puppet.silent = False
        return "CH1"

    def _note(self, deed: str) -> None:
        self.deeds.append((deed, clock().now_s()))


class Floor:
    """One operator and one puppet, and what happens between them."""

    def __init__(self, habits: Habits, area: str = "AREA1", seed: int = 1) -> None:
        self.bus = bus = SimNetwork(clock(), Random(seed))
        self.puppet = Puppet(bus)
        self.hands = FakeHands(self.puppet)
        self.operator = Operator(
            area,
            plant=PLANT,
            bus=bus,
            clock=clock(),
            authority=AUTHORITY,
            hands=self.hands,
            random=Random(seed),
            habits=habits,
        )

    @property
    def deeds(self) -> list[str]:
        return [deed for deed, _ in self.hands.deeds]


Story = Callable[[Floor], Coroutine[object, object, None]]


def play(story: Story, habits: Habits = QUICK, area: str = "AREA1", seed: int = 1) -> Floor:
    """Let a story happen while operator and puppet live."""

    async def main() -> Floor:
        floor = Floor(habits, area, seed)
        lives = [asyncio.create_task(floor.puppet.run()), asyncio.create_task(floor.operator.run())]
        await story(floor)
        for life in lives:
            life.cancel()
        await asyncio.gather(*lives, return_exceptions=True)
        return floor

    return run(main())


async def until(true: Callable[[], bool]) -> None:
    """Go on when something is so; looked at once a second of virtual time."""
    while not true():  # noqa: ASYNC110 (nobody tells)
        await asyncio.sleep(1.0)


def trouble(problem: str, *, waits_s: float | None = None, for_s: float = 300.0) -> Story:
    """A vehicle has a problem."""

    async def story(floor: Floor) -> None:
        floor.puppet.status, floor.puppet.problem = AtvStatus.ERROR, problem
        if waits_s is not None:
            floor.puppet.help = HelpWanted(until_s=clock().now_s() + waits_s)
        await asyncio.sleep(for_s)

    return story


# --- problems ---


def test_a_problem_is_mended_on_the_spot_without_a_stop() -> None:
    floor = play(trouble("blocked way"))
    assert floor.deeds == ["mend"]
    assert floor.hands.deeds[0][1] == pytest.approx(LOOK_S + 1.0 + 10.0 + 20.0)
    assert floor.puppet.heard == []
    assert floor.operator.done[Duty.HELP] == 1


def test_help_that_is_asked_for_is_promised_for_as_long_as_it_takes() -> None:
    floor = play(trouble("blocked way", waits_s=100.0))
    ((at_s, promise),) = floor.puppet.heard
    assert (promise.kind, promise.issued_by) == (CommandKind.PROMISE, "operator-AREA1")
    mended_s = floor.hands.deeds[0][1]
    assert promise.wait_s == 30.0
    assert at_s + promise.wait_s == pytest.approx(mended_s, abs=0.5)


def test_who_promises_nothing_comes_all_the_same() -> None:
    floor = play(trouble("blocked way", waits_s=100.0), replace(QUICK, promises_frac=0.0))
    assert floor.puppet.heard == []
    assert floor.deeds == ["mend"]


def test_a_shifted_load_is_secured_by_stop_acknowledge_and_resume_in_this_order() -> None:
    floor = play(trouble(LOAD_SHIFTED))
    assert floor.puppet.kinds == [CommandKind.STOP, CommandKind.ACKNOWLEDGE, CommandKind.RESUME]
    (stop_s, _), (acknowledge_s, _), _ = floor.puppet.heard
    assert floor.deeds == ["mend"]
    assert stop_s + 20.0 <= floor.hands.deeds[0][1] <= acknowledge_s
    assert floor.puppet.status is AtvStatus.WORKING


def test_a_shifted_load_is_driven_on_slowly_and_later_as_before() -> None:
    floor = play(trouble(LOAD_SHIFTED), replace(QUICK, slow_frac=0.4, slow_s=60.0))
    assert floor.puppet.kinds == [
        CommandKind.STOP,
        CommandKind.SET_SPEED,
        CommandKind.ACKNOWLEDGE,
        CommandKind.RESUME,
        CommandKind.SET_SPEED,
    ]
    slow, fast = ((at_s, each) for at_s, each in floor.puppet.heard if each.kind is CommandKind.SET_SPEED)
    assert (slow[1].speed_frac, fast[1].speed_frac) == (0.4, 1.0)
    assert 60.0 <= fast[0] - slow[0] <= 60.0 + 2 * LOOK_S


def test_every_command_is_said_again_until_it_is_answered_and_before_the_next() -> None:
    async def story(floor: Floor) -> None:
        floor.puppet.deaf = 3
        await trouble(LOAD_SHIFTED)(floor)

    floor = play(story)
    stops = [(at_s, each) for at_s, each in floor.puppet.heard if each.kind is CommandKind.STOP]
    assert len(stops) == 4
    assert len({each.command for _, each in stops}) == 1
    assert stops[1][0] - stops[0][0] == pytest.approx(ANSWER_S, abs=0.3)
    assert floor.puppet.kinds == [CommandKind.STOP, CommandKind.ACKNOWLEDGE, CommandKind.RESUME]


def test_a_stop_that_was_not_released_is_released_when_the_vehicle_hears_again() -> None:
    async def story(floor: Floor) -> None:
        floor.puppet.status, floor.puppet.problem = AtvStatus.ERROR, LOAD_SHIFTED
        await until(lambda: floor.puppet.status is AtvStatus.STOPPED)
        # Longer than anybody goes on saying it, and the heartbeats are heard all the time.
        floor.puppet.deaf = TRIES
        await asyncio.sleep(20.0 + TRIES * ANSWER_S + 5.0)
        assert floor.puppet.status is AtvStatus.STOPPED
        await asyncio.sleep(60.0)

    floor = play(story)
    assert floor.puppet.status is AtvStatus.WORKING
    assert floor.operator.done[Duty.RELEASE] == 1


def test_a_refused_acknowledge_is_not_followed_by_a_resume() -> None:
    async def story(floor: Floor) -> None:
        floor.puppet.refuses = {CommandKind.ACKNOWLEDGE}
        await trouble(LOAD_SHIFTED)(floor)

    assert CommandKind.RESUME not in play(story).puppet.kinds


def test_somebody_elses_stop_is_left_to_them() -> None:
    async def story(floor: Floor) -> None:
        floor.puppet.status, floor.puppet.problem = AtvStatus.STOPPED, LOAD_SHIFTED
        await asyncio.sleep(300.0)

    floor = play(story)
    assert floor.deeds == ["mend"]
    assert floor.puppet.heard == []
    assert floor.puppet.status is AtvStatus.STOPPED


def crew(floor: Floor) -> tuple[Operator, Operator]:
    """The operator of AREA1, and a colleague in AREA2."""
    colleague = Operator(
        "AREA2",
        plant=PLANT,
        bus=floor.bus,
        clock=clock(),
        authority=AUTHORITY,
        hands=floor.hands,
        random=Random(2),
        habits=QUICK,
    )
    both = {"AREA1": floor.operator, "AREA2": colleague}
    floor.operator.colleagues = colleague.colleagues = both
    return floor.operator, colleague


def test_a_stop_beyond_the_border_is_ended_by_the_colleague_there() -> None:
    ended: list[int] = []

    async def story(floor: Floor) -> None:
        here, there = crew(floor)
        life = asyncio.create_task(there.run())
        floor.puppet.status, floor.puppet.problem = AtvStatus.ERROR, LOAD_SHIFTED
        await until(lambda: floor.puppet.status is AtvStatus.STOPPED)
        # It rolls a little further, out of the area.
        floor.puppet.pose = BEYOND
        await until(lambda: floor.puppet.status is AtvStatus.WORKING)
        ended.extend(each.done[Duty.RELEASE] for each in (here, there))
        await asyncio.sleep(10.0)
        life.cancel()

    floor = play(story)
    assert [sender for sender, command in floor.puppet.obeyed if command is CommandKind.RESUME] == [
        "operator-AREA2"
    ]
    assert ended[0] == 0


def test_a_stop_that_is_refused_is_forgotten_and_nobody_reaches_in() -> None:
    async def story(floor: Floor) -> None:
        floor.puppet.status, floor.puppet.problem = AtvStatus.ERROR, LOAD_SHIFTED
        # On its way to the vehicle, which has meanwhile slipped once more in another area.
        await asyncio.sleep(LOOK_S + 5.0)
        floor.puppet.pose = SOUTH
        await asyncio.sleep(300.0)

    floor = play(story)
    assert (floor.deeds, floor.puppet.obeyed) == ([], [])


def test_a_problem_that_is_gone_on_arrival_is_left_alone() -> None:
    async def story(floor: Floor) -> None:
        await trouble("blocked way", for_s=10.0)(floor)
        floor.puppet.status, floor.puppet.problem = AtvStatus.WORKING, ""
        await asyncio.sleep(100.0)

    assert play(story).deeds == []


def test_a_healthy_vehicle_is_left_alone() -> None:
    async def story(_floor: Floor) -> None:
        await asyncio.sleep(1000.0)

    floor = play(story)
    assert (floor.deeds, floor.puppet.heard) == ([], [])


def test_a_vehicle_in_another_area_is_somebody_elses() -> None:
    async def story(floor: Floor) -> None:
        floor.puppet.pose = SOUTH
        await trouble("blocked way")(floor)

    assert play(story).deeds == []
    assert play(story, area=area_at(PLANT, SOUTH.x_m, SOUTH.y_m)).deeds == ["mend"]


def test_nobody_comes_while_nobody_is_there() -> None:
    away = replace(QUICK, present_frac=0.0, away_s=(50.0, 50.0))
    assert play(trouble("blocked way"), away).deeds == []


# --- silence ---


def silence(load: tuple[str, int] = ("", 0), *, off: bool = True, for_s: float = 200.0) -> Story:
    """A vehicle that carries for M8 is heard, and then no more."""

    async def story(floor: Floor) -> None:
        floor.puppet.task = Brief(
            task="M8-1", epoch=1, role=Role.PRIMARY, coordinator="M8", phase=Phase.CARRYING
        )
        await asyncio.sleep(3.0)
        floor.puppet.silent, floor.hands.off, floor.hands.load = True, off, load
        await asyncio.sleep(for_s)

    return story


def test_a_silent_vehicle_is_cleared_up_and_brought_home() -> None:
    floor = play(silence(("P1", 5)))
    assert floor.deeds == ["unload", "put down", "bring home"]
    assert floor.hands.put == ("P1", 5, "n1", "M8")
    assert floor.hands.deeds[0][1] >= 3.0 + QUICK.silent_s + 1.0 + 10.0 - 1.0
    assert floor.operator.done[Duty.RECOVER] == 1


def test_an_empty_one_is_brought_home_at_once() -> None:
    assert play(silence()).deeds == ["unload", "bring home"]


def test_a_silent_vehicle_whose_lights_are_on_is_left_alone_until_it_is_heard_again() -> None:
    floor = play(silence(off=False, for_s=1000.0))
    assert floor.deeds == []
    assert floor.operator.done[Duty.RECOVER] == 1


def test_a_vehicle_that_comes_back_by_itself_meanwhile_is_not_pushed_away() -> None:
    async def story(floor: Floor) -> None:
        await silence(("P1", 5), for_s=30.0)(floor)
        await until(lambda: floor.deeds == ["unload"])
        floor.hands.off = floor.puppet.silent = False
        await asyncio.sleep(100.0)

    assert play(story).deeds == ["unload", "put down"]


# --- chance ---


def test_chance_follows_from_the_seed_alone() -> None:
    def moments(seed: int) -> list[tuple[str, float]]:
        return play(trouble(LOAD_SHIFTED), Habits(), seed=seed).hands.deeds

    assert moments(1) == moments(1)
    assert moments(1) != moments(2)


# --- areas ---


def test_every_point_has_one_area() -> None:
    assert area_at(PLANT, 30.0, 30.0) == "AREA1"
    assert area_at(PLANT, 30.0, 26.0) == "AREA1"
    assert area_at(PLANT, 30.0, 1000.0) == "AREA1"


def test_everybody_who_is_hired_has_an_area_and_a_name() -> None:
    async def main() -> list[str]:
        return [each.name for each in hire(SimFactory(PLANT, clock(), seed=1), seed=1)]

    assert run(main()) == [f"operator-{area}" for area in PLANT.areas]


# --- hands ---


@pytest.fixture
def factory() -> SimFactory:
    async def main() -> SimFactory:
        return SimFactory(PLANT, clock(), seed=1)

    return run(main())


def carry(factory: SimFactory, item: str, quantity: int) -> Hands:
    """Somebody has pieces in hand."""
    factory.in_hands[item] += quantity
    return Hands(factory)


def test_material_goes_to_the_nearest_storage_that_has_room(factory: SimFactory) -> None:
    material = next(item for item in PLANT.materials if len(PLANT.storages_of(item)) > 1)
    far, near = PLANT.storages_of(material)[:2]
    factory.storages[far].take("", material, 5)
    hands = carry(factory, material, 5)
    assert hands.put_down(material, 5, PLANT.node_of(near)) == far
    assert factory.in_hands[material] == 0
    factory.storages[far].take("", material, 5)
    factory.storages[near].take("", material, 5)
    assert carry(factory, material, 5).put_down(material, 5, PLANT.node_of(near)) == near


def test_material_without_room_anywhere_goes_back_to_the_source(factory: SimFactory) -> None:
    material = next(iter(PLANT.materials))
    assert carry(factory, material, 5).put_down(material, 5, "c3") == factory.source.id
    assert factory.source.returned[material] == 5


def test_goods_go_back_to_their_machine(factory: SimFactory) -> None:
    machine = next(iter(PLANT.machines.values()))
    product = machine.makes[0].product
    assert carry(factory, product, 2).put_down(product, 2, "c3", machine.id) == machine.id
    assert factory.workcells[machine.id].sense().stock[product] == 2


def test_goods_of_nobody_are_set_aside(factory: SimFactory) -> None:
    product = next(iter(PLANT.products))
    place = carry(factory, product, 2).put_down(product, 2, "c3")
    warehouse = factory.delivery[place]
    assert warehouse.arrived[product] + warehouse.aside[product] == 2
    assert factory.in_hands[product] == 0


def test_a_dead_vehicle_is_pushed_to_a_charger_where_none_stands(factory: SimFactory) -> None:
    dead, other = factory.vehicles["ATV1"], factory.vehicles["ATV2"]
    hands = Hands(factory)
    dead.break_down("wheel")
    factory.power_off("ATV1")
    first = hands.bring_home("ATV1")
    assert (dead.off, dead.problem, dead.sense().node) == (False, "", PLANT.node_of(first))
    factory.power_off("ATV1")
    other.place_at(PLANT.node_of(first))
    dead.place_at("c3")
    assert hands.bring_home("ATV1") not in ("", first)


def test_an_empty_battery_is_exchanged(factory: SimFactory) -> None:
    vehicle = factory.vehicles["ATV1"]
    vehicle.replace_battery(0.0)
    while vehicle.problem != BATTERY_EMPTY:
        when_s, _, callback, args = factory.clock.heap.pop(0)
        factory.clock.time_s = max(factory.clock.time_s, when_s)
        callback(*args)
    Hands(factory).mend("ATV1")
    assert (vehicle.problem, vehicle.sense().battery_frac) == ("", 1.0)


# --- all of it in a running factory ---


async def _misfortunes(
    seed: int, turns: int = 12, *network: LinkTrouble
) -> tuple[SimFactory, Invariants, Counter[Duty]]:
    """A time in which loads shift and vehicles break or die, and people help."""
    listeners = Listeners()
    factory = SimFactory(PLANT, clock(), seed=seed, listener=listeners)
    checks = Invariants(factory)
    listeners.add(checks)
    faults = Faults(factory)
    for each in network:
        faults.begin(each)
    crew = hire(factory, seed=seed)
    orders = demand.orders(PLANT, Random(seed), load=0.9, until_s=1800.0)
    chance = Random(seed)
    async with asyncio.TaskGroup() as group:
        lives = [group.create_task(factory.run())]
        lives += [group.create_task(Desk(factory.bus, factory.clock).place(orders))]
        lives += [group.create_task(operator.run()) for operator in crew]
        await asyncio.sleep(200.0)
        for turn in range(turns):
            atv = chance.choice(list(factory.vehicles))
            if turn % 3 == 0:
                factory.vehicles[atv].break_down("blocked way")
            elif turn % 3 == 1:
                await until(lambda: any(each.shift_load() for each in factory.vehicles.values()))
            else:
                factory.power_off(atv)
            await asyncio.sleep(100.0)
        await asyncio.sleep(1200.0)
        for life in lives:
            life.cancel()
    checks.check_end(factory.clock.now_s())
    return factory, checks, sum((Counter(operator.done) for operator in crew), Counter())


def assert_all_is_well(factory: SimFactory) -> None:
    for vehicle in factory.vehicles.values():
        assert (vehicle.off, vehicle.problem, vehicle.sense().held) == (False, "", False)


def test_people_bring_everything_back_to_life_and_no_piece_is_lost() -> None:
    factory, checks, done = run(_misfortunes(seed=5))
    assert_all_is_well(factory)
    assert done[Duty.HELP] >= 8
    assert done[Duty.RECOVER] >= 4
    assert sum(factory.in_hands.values()) == 0
    assert checks.broken is None


def test_no_stop_outlives_its_operator_though_words_are_lost_doubled_and_overtaken() -> None:
    bad = LinkTrouble(latency_s=0.1, jitter_s=1.0, loss_frac=0.2, duplicate_frac=0.3, reorder_frac=0.5)
    factory, _, done = run(_misfortunes(3, 6, bad))
    assert_all_is_well(factory)
    assert done[Duty.SPEED_UP] >= 2, "more often when the vehicle has driven on into another area"
