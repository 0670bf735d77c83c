"""Bodies on a floor elsewhere: whose they are, over the lives of agents and floors."""

from __future__ import annotations

import asyncio

import pytest
from floor_house import ATV, PLANT, SPEED, House, Leaky, Listener, in_a_house, way_of
from prometheus_client import CollectorRegistry
from zenoh_kit import PATIENCE_S

from dray.adapters import crossing
from dray.adapters.remote_body import RemoteBody, exchange, questions
from dray.adapters.remote_body.exchanged import LOOK_EVERY_S, SILENT_LOOKS
from dray.body import (
    Drive,
    Hold,
    NodePassed,
    Unhold,
    WayDone,
)
from dray.cli.simulation.floor_meter import FloorMeter
from dray.errors import UnavailableError
from dray_sim.clock.loop import clock
from dray_sim.remote import count_pieces


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


def test_a_body_that_cannot_be_told_of_by_our_own_fault_costs_no_other_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async def test(house: House) -> None:
        machine = next(iter(PLANT.machines))
        vehicle, _ = await house.take_over(ATV, 1), await house.take_over(machine, 1)
        monkeypatch.setattr(house.floor.workcells[machine], "sense", lambda: {}["of a bug"])
        listener = Listener(vehicle)
        vehicle.instruct(Drive(order=1, nodes=way_of(ATV), released=len(way_of(ATV))))
        await listener.until(WayDone)
        assert house.server.failures.total
        assert not house.serving.done()
        monkeypatch.undo()

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
        # The next life may be told more than that at once.
        monkeypatch.undo()
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


def test_a_body_that_is_taken_over_twice_by_one_life_is_as_new_as_before() -> None:
    async def test(house: House) -> None:
        body = await house.take_over(ATV, 1)
        await body.connect()
        assert body.is_new

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
