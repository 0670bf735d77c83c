"""Bodies on a floor elsewhere: agents use them as their own, and leave them behind."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from random import Random
from typing import Any

import pytest
import zenoh
from msgspec.structs import replace
from prometheus_client import CollectorRegistry
from zenoh_kit import PATIENCE_S, Row

from dray.adapters import crossing
from dray.adapters.crossing import Crossing
from dray.adapters.remote_body import RemoteBody, exchange, put_down, questions
from dray.adapters.remote_body.body import LOOK_EVERY_S, SILENT_LOOKS
from dray.adapters.zenoh.bus import ZenohBus
from dray.body import (
    Admit,
    Broken,
    Drive,
    Hold,
    NodePassed,
    ReleaseWay,
    Report,
    Unhold,
    VehicleState,
    WayDone,
    WorkcellState,
)
from dray.cli.simulation.floor_meter import FloorMeter
from dray.errors import UnavailableError
from dray.plant import default_plant
from dray_sim.bodies.floor import Floor
from dray_sim.clock.loop import clock, paced, run
from dray_sim.remote import FloorServer, count_pieces

PLANT = default_plant()
SPEED = 20.0
ATV = next(iter(PLANT.fleet))


class House:
    """A floor in one session, the session of its agents, and one for the floor that comes after it."""

    def __init__(self, row: Row, group: asyncio.TaskGroup) -> None:
        self._row, self._group = row, group
        self.here = row.buses[1].inner
        self.there = row.buses[0].inner
        self.floor, self.serving = self._serve(row.buses[0])
        self.settle = row.settle

    def end(self) -> None:
        """The floor's process ends."""
        self.serving.cancel()
        self.server.end()
        self._row.buses[0].close()

    def begin_anew(self) -> None:
        """The floor's process ends, and another one starts."""
        self.end()
        self.floor, self.serving = self._serve(self._row.buses[2])

    def _serve(self, bus: ZenohBus) -> tuple[Floor, asyncio.Task[None]]:
        floor = Floor(PLANT, clock(), seed=1)
        self.server = FloorServer(bus.inner, PLANT.id, floor)
        return floor, self._group.create_task(self.server.run())

    async def take_over(self, agent: str, life: int, session: Any = None) -> RemoteBody:
        body = RemoteBody(session or self.here, PLANT.id, agent, life)
        await body.connect()
        return body


def in_a_house(test: Callable[[House], Coroutine[Any, Any, None]]) -> None:
    async def main() -> None:
        row = Row(3, PLANT.id)
        try:
            async with asyncio.TaskGroup() as group:
                house = House(row, group)
                await row.settle()
                await test(house)
                house.serving.cancel()
        finally:
            row.close()

    run(main(), paced(SPEED))


class Listener:
    """What a body reports, and a way to wait for it."""

    def __init__(self, body: RemoteBody) -> None:
        self.reports: list[Report] = []
        self._came = asyncio.Event()
        body.attach(self._on_report)

    def _on_report(self, report: Report) -> None:
        self.reports.append(report)
        self._came.set()

    async def until(self, kind: type[Report]) -> None:
        async with asyncio.timeout(PATIENCE_S * SPEED):
            while not any(type(report) is kind for report in self.reports):
                self._came.clear()
                await self._came.wait()


def test_an_agent_senses_a_body_that_is_elsewhere() -> None:
    async def test(house: House) -> None:
        for agent, there in house.floor.bodies.items():
            body = await house.take_over(agent, 1)
            assert type(body.sense()) is type(there.sense())
        machine = next(iter(PLANT.machines))
        body = await house.take_over(machine, 2)
        assert body.sense() == house.floor.workcells[machine].sense()

    in_a_house(test)


def test_what_happens_there_is_reported_here_with_the_state_after_it() -> None:
    async def test(house: House) -> None:
        machine = next(iter(PLANT.machines))
        body = await house.take_over(machine, 1)
        listener = Listener(body)
        house.floor.workcells[machine].break_down("a belt has torn")
        await listener.until(Broken)
        state = body.sense()
        assert isinstance(state, WorkcellState)
        assert state.broken == "a belt has torn"

    in_a_house(test)


def test_what_happens_on_a_floor_that_has_ended_is_told_to_nobody() -> None:
    async def test(house: House) -> None:
        machine = next(iter(PLANT.machines))
        await house.take_over(machine, 1)
        house.end()
        house.floor.workcells[machine].break_down("a belt has torn")
        # What it says is heard at this instant, and so before this.
        heard = asyncio.Event()
        clock().call_at(clock().now_s(), heard.set)
        await heard.wait()
        assert house.server.traffic.reports == 0

    in_a_house(test)


def way_of(vehicle: str) -> tuple[str, ...]:
    """A way of the vehicle from where it stands to a machine."""
    spec = PLANT.fleet[vehicle]
    goal = PLANT.node_of(next(iter(PLANT.machines)))
    return PLANT.routes(spec.type).way(spec.node, goal).nodes


def test_a_vehicle_drives_there_as_it_is_told_here() -> None:
    async def test(house: House) -> None:
        nodes = way_of(ATV)
        body = await house.take_over(ATV, 1)
        listener = Listener(body)
        body.instruct(Drive(order=1, nodes=nodes, released=len(nodes)))
        await listener.until(WayDone)
        assert [report.node for report in listener.reports if isinstance(report, NodePassed)] == list(nodes)
        state = body.sense()
        assert isinstance(state, VehicleState)
        assert state.node == nodes[-1]

    in_a_house(test)


class Leaky:
    """A session that lets only some of what is said through."""

    def __init__(self, session: Any, seed: int, through_frac: float = 0.25) -> None:
        self._session, self._random, self._through_frac = session, Random(seed), through_frac

    def __getattr__(self, name: str) -> Any:
        return getattr(self._session, name)

    def put(self, key: str, data: bytes) -> None:
        if self._random.random() < self._through_frac:
            self._session.put(key, data)


def test_instructions_and_reports_arrive_once_and_in_order_also_when_most_messages_are_lost() -> None:
    async def test(house: House) -> None:
        nodes = way_of(ATV)
        house.serving.cancel()
        floor = Floor(PLANT, clock(), seed=1)
        server: Any = Leaky(house.there, 1)
        telling = asyncio.create_task(FloorServer(server, PLANT.id, floor).run())
        body = await house.take_over(ATV, 5, Leaky(house.here, 2))
        listener = Listener(body)
        body.instruct(Drive(order=1, nodes=nodes, released=1))
        for released in range(2, len(nodes) + 1):
            body.instruct(ReleaseWay(order=1, released=released))
        await listener.until(WayDone)
        assert [report.node for report in listener.reports if isinstance(report, NodePassed)] == list(nodes)
        telling.cancel()

    in_a_house(test)


def test_a_life_that_has_not_heard_too_much_has_lost_its_body(monkeypatch: pytest.MonkeyPatch) -> None:
    async def test(house: House) -> None:
        machine = next(iter(PLANT.machines))
        body = await house.take_over(machine, 1, Leaky(house.here, 1, through_frac=0.0))
        workcell = house.floor.workcells[machine]
        workcell.break_down("a belt has torn")
        with pytest.raises(TimeoutError):
            await asyncio.wait_for(body.lost(), 2 * SILENT_LOOKS * LOOK_EVERY_S)
        workcell.repair()
        await asyncio.wait_for(body.lost(), PATIENCE_S * SPEED)
        assert not (await house.take_over(machine, 2)).is_new

    monkeypatch.setattr(exchange, "KEPT_MAX", 1)
    in_a_house(test)


def test_a_life_that_is_not_heard_too_long_gives_its_body_up_and_leaves_no_instruction_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async def test(house: House) -> None:
        nodes = way_of(ATV)
        there = house.floor.vehicles[ATV]
        body = await house.take_over(ATV, 1, Leaky(house.here, 1, through_frac=0.0))
        lost = asyncio.create_task(body.lost())
        body.instruct(Hold())
        body.instruct(Drive(order=1, nodes=nodes, released=len(nodes)))
        body.instruct(Unhold())
        await asyncio.wait_for(lost, PATIENCE_S * SPEED)
        assert not there.sense().held
        after = await house.take_over(ATV, 2)
        listener = Listener(after)
        after.instruct(Drive(order=2, nodes=nodes, released=len(nodes)))
        await listener.until(WayDone)
        assert {report.order for report in listener.reports if isinstance(report, NodePassed)} == {2}

    monkeypatch.setattr(exchange, "KEPT_MAX", 2)
    in_a_house(test)


def test_a_floor_that_is_too_far_behind_refuses_questions_and_its_bodies_are_not_lost(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async def test(house: House) -> None:
        body = await house.take_over(ATV, 1)
        house.serving.cancel()
        monkeypatch.setattr(crossing, "QUEUE", 0)
        with pytest.raises(UnavailableError, match="refuses: too much waits there"):
            await count_pieces(house.here, PLANT.id)
        with pytest.raises(TimeoutError):
            await asyncio.wait_for(body.lost(), 2 * SILENT_LOOKS * LOOK_EVERY_S)
        monkeypatch.undo()
        assert await count_pieces(house.here, PLANT.id) == house.floor.count()

    in_a_house(test)


def test_letters_that_find_no_room_are_said_again(monkeypatch: pytest.MonkeyPatch) -> None:
    async def test(house: House) -> None:
        nodes = way_of(ATV)
        body = await house.take_over(ATV, 1)
        listener = Listener(body)
        # By chance: every fourth one might for ever be the same side's.
        offer, chance, refused = Crossing.offer, Random(1), 0

        def offer_one_in_four(self: Crossing, call: Callable[..., object], *args: Any) -> bool:
            nonlocal refused
            if chance.random() < 0.25:
                return offer(self, call, *args)
            refused += 1
            return False

        monkeypatch.setattr(Crossing, "offer", offer_one_in_four)
        body.instruct(Drive(order=1, nodes=nodes, released=len(nodes)))
        await listener.until(WayDone)
        assert refused
        assert [report.node for report in listener.reports if isinstance(report, NodePassed)] == list(nodes)

    in_a_house(test)


def test_a_joining_agent_that_does_not_fit_is_refused_with_the_reason() -> None:
    async def test(house: House) -> None:
        with pytest.raises(UnavailableError, match="has no type 'submarine'"):
            await put_down(house.here, PLANT.id, replace(PLANT.fleet[ATV], id="ATV99", type="submarine"))
        with pytest.raises(UnavailableError, match="has no node 'moon'"):
            await put_down(house.here, PLANT.id, replace(PLANT.fleet[ATV], id="ATV99", node="moon"))

    in_a_house(test)


def test_a_body_obeys_the_latest_life_of_its_agent_alone_and_goes_on_meanwhile() -> None:
    async def test(house: House) -> None:
        nodes = way_of(ATV)
        dead = await house.take_over(ATV, 1)
        dead.instruct(Drive(order=1, nodes=nodes, released=len(nodes)))
        after = await house.take_over(ATV, 2)
        listener = Listener(after)
        dead.instruct(Drive(order=2, nodes=nodes[:1], released=1))
        await listener.until(WayDone)
        assert house.floor.vehicles[ATV].sense().node == nodes[-1]

    in_a_house(test)


def test_a_floor_tells_who_has_its_bodies_and_what_went_between_them_over_all_lives(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async def test(house: House) -> None:
        registry = CollectorRegistry()
        registry.register(FloorMeter(house.server))

        def told(name: str, **labels: str) -> float | None:
            return registry.get_sample_value(f"dray_floor_{name}", labels)

        count = len(house.floor.bodies)
        assert (told("bodies", state="free"), told("bodies", state="taken")) == (count, 0)
        nodes = way_of(ATV)
        dead = await house.take_over(ATV, 1)
        listener = Listener(dead)
        dead.instruct(Drive(order=1, nodes=nodes, released=len(nodes)))
        await listener.until(WayDone)
        assert (told("bodies", state="free"), told("bodies", state="taken")) == (count - 1, 1)
        reports = told("reports_total")
        assert reports == len(listener.reports)
        assert told("instructions_total") == 1
        await house.take_over(ATV, 2)
        assert told("reports_total") == reports, "a new life forgets nothing"
        dead.instruct(Hold())
        while not told("letters_refused_total", reason="of an earlier life"):
            await count_pieces(house.here, PLANT.id)
        assert told("instructions_total") == 1
        machine = next(iter(PLANT.machines))
        await house.take_over(machine, 1, Leaky(house.here, 1, through_frac=0.0))
        monkeypatch.setattr(exchange, "KEPT_MAX", 1)
        workcell = house.floor.workcells[machine]
        workcell.break_down("a belt has torn")
        while not told("reports_waiting"):
            await count_pieces(house.here, PLANT.id)
        workcell.repair()
        while not told("bodies", state="lost"):
            await count_pieces(house.here, PLANT.id)
        assert (told("bodies", state="lost"), told("bodies", state="taken")) == (1, 1)

    in_a_house(test)


def test_without_a_floor_an_agent_does_not_begin(monkeypatch: pytest.MonkeyPatch) -> None:
    async def test(house: House) -> None:
        stranger = RemoteBody(house.here, PLANT.id, "ATV99", 1)
        with pytest.raises(UnavailableError, match="the body of ATV99: nobody answers over 2 links"):
            await stranger.connect()

    monkeypatch.setattr(questions, "PATIENCE_S", 0.5)
    in_a_house(test)


def test_a_question_that_is_lost_is_asked_again(monkeypatch: pytest.MonkeyPatch) -> None:
    async def test(house: House) -> None:
        lost: list[zenoh.Query] = []
        keep = zenoh.handlers.Callback(lost.append, indirect=False)

        class Forgetful(Leaky):
            """Its first question goes to somebody who never answers."""

            def get(self, key: str, *args: Any, **options: Any) -> None:
                self._session.get(key if lost else "nobody/answers", *args, **options)

        house.there.declare_queryable("nobody/answers", keep)
        await house.settle()
        body = await house.take_over(ATV, 1, Forgetful(house.here, 1))
        assert len(lost) == 1
        assert body.is_new

    monkeypatch.setattr(questions, "ANSWER_S", 0.2)
    in_a_house(test)


def test_a_body_that_is_taken_over_twice_by_one_life_is_as_new_as_before() -> None:
    async def test(house: House) -> None:
        body = await house.take_over(ATV, 1)
        await body.connect()
        assert body.is_new

    in_a_house(test)


def test_a_joining_agent_is_put_down_once_and_drives() -> None:
    spec = replace(PLANT.fleet[ATV], id="ATV99")

    async def test(house: House) -> None:
        for _ in range(2):
            await put_down(house.here, PLANT.id, spec)
        assert len(house.floor.vehicles) == len(PLANT.fleet) + 1
        nodes = way_of(ATV)
        body = await house.take_over("ATV99", 1)
        listener = Listener(body)
        body.instruct(Drive(order=1, nodes=nodes, released=len(nodes)))
        await listener.until(WayDone)
        assert house.floor.vehicles["ATV99"].sense().node == nodes[-1]

    in_a_house(test)


def test_the_pieces_of_a_floor_are_counted_from_elsewhere() -> None:
    async def test(house: House) -> None:
        there = house.floor
        assert await count_pieces(house.here, PLANT.id) == there.count()
        there.gate.instruct(Admit(goal="G1", quantity=5))
        warehouse, product = next(iter(there.delivery.values())), next(iter(PLANT.products))
        assert warehouse.put(ATV, product, 5, "G1") == ""
        pieces = await count_pieces(house.here, PLANT.id)
        assert (pieces.arrived, pieces.delivered) == ({"G1": 5}, {product: 5})

    in_a_house(test)


def test_a_body_is_lost_with_its_floor_and_not_while_that_is_only_busy() -> None:
    async def test(house: House) -> None:
        body = await house.take_over(ATV, 1)
        for _ in ("it tells", "it is too busy for it"):
            with pytest.raises(TimeoutError):
                await asyncio.wait_for(body.lost(), 2 * SILENT_LOOKS * LOOK_EVERY_S)
            house.serving.cancel()
        house.end()
        await asyncio.wait_for(body.lost(), PATIENCE_S * SPEED)

    in_a_house(test)


def test_a_floor_that_has_begun_anew_says_so_and_keeps_silent_to_whoever_took_its_last_body_over() -> None:
    async def test(house: House) -> None:
        before = await house.take_over(ATV, 1)
        assert before.is_new
        assert not (await house.take_over(ATV, 2)).is_new
        house.begin_anew()
        await asyncio.wait_for(before.lost(), PATIENCE_S * SPEED)
        assert (await house.take_over(ATV, 3)).is_new

    in_a_house(test)
