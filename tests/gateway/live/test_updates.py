"""What a panel makes of its frames is what the gateway knows: at every pace, whenever it has come, whatever it has missed."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator
from random import Random
from typing import Any

import msgspec
import pytest
from fake_bus import PLANT
from heartbeats import atv_heartbeat
from msgspec.structs import replace
from wall_clock import NOW_S, Wall

from dray.gateway.access.principal import ADMIN, SCOPES, Principal, Role
from dray.gateway.live import stream as stream_module
from dray.gateway.live.frames import COLLECTIONS, PORTION
from dray.gateway.live.projection import Projection
from dray.gateway.live.stream import CALM_S, QUIET_S, Client, Hub, Pace, scope_of
from dray.gateway.live.timescale import TimeScale
from dray.messages import Message
from dray.messages.keys import Keys
from dray.plant import Plant, default_plant
from dray.store.orders.orders import Item, Order
from dray.store.orders.progress import OrderStatus
from dray_sim.clock.loop import clock, run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.people import demand
from dray_sim.people.order_client import OrderClient

STEP_S = 1.0
"""Of the factory's clock, which jumps: nothing waits for it."""

QUEUE = 4
"""Frames that wait for a client here."""

OPERATOR = Principal(
    kind="person",
    id="operator",
    name="Operator",
    role=Role.OPERATOR,
    scopes=SCOPES[Role.OPERATOR],
    areas=frozenset({"area1"}),
)


class Panel:
    """What a browser makes of its frames (`frontend/src/stream/world.ts`)."""

    def __init__(self, hub: Hub, who: Principal = ADMIN, pace: Pace = Pace.LIVE) -> None:
        client = hub.join(who, pace)
        assert client is not None
        self.client: Client = client
        self.number = -1
        self.snapshots = 0
        self.seen: dict[str, dict[str, Any]] = {}

    async def read_all(self) -> None:
        while self.client._ready.is_set():
            self._take(json.loads(await self.client.next_frame()))

    def _take(self, frame: dict[str, Any]) -> None:
        if frame["type"] == "snapshot":
            self.snapshots += 1
            self.seen = {
                kind: {each["id"]: each for each in frame[name]} for kind, name in COLLECTIONS.items()
            }
        else:
            assert frame["number"] == self.number + 1
            for kind, name in COLLECTIONS.items():
                for patch in frame[name]:
                    self.seen[kind][patch["id"]] = self.seen[kind].get(patch["id"], {}) | patch
            for gone in frame["gone"]:
                kind, _, entity = gone.partition(":")
                self.seen[kind].pop(entity, None)
        self.number = frame["number"]


def everything(hub: Hub, who: Principal) -> dict[str, dict[str, Any]]:
    """What a snapshot would say that is made at this moment, for nobody else."""
    frame = json.loads(msgspec.json.encode(scope_of(hub._projection, who).snapshot(0, 0.0)))
    return {kind: {each["id"]: each for each in frame[name]} for kind, name in COLLECTIONS.items()}


async def seconds(plant: Plant, projection: Projection, count: int) -> AsyncIterator[int]:
    """A factory at work of which a projection hears all, second by second."""
    factory = SimFactory(plant, clock(), seed=7)
    session = factory.bus.join("panel", lambda _sender, message: projection.fold(message))
    keys = Keys(plant.id)
    session.subscribe(keys.all_heartbeats)
    session.subscribe(keys.all_events)
    orders = demand.orders(plant, Random(7), load=0.85, until_s=float(count))
    async with asyncio.TaskGroup() as group:
        tasks = [
            group.create_task(factory.run()),
            group.create_task(OrderClient(factory.bus, factory.clock).place(orders)),
        ]
        for step in range(count):
            await asyncio.sleep(STEP_S)
            yield step
        for task in tasks:
            task.cancel()


def test_a_panel_that_is_told_by_changes_alone_sees_at_every_moment_what_the_gateway_knows() -> None:
    """Nobody is slow and nobody comes later, so nothing but the first snapshot is told whole."""
    plant, wall = default_plant(), Wall()
    projection = Projection(plant.file, TimeScale(0.0, NOW_S))
    hub = Hub(projection, wall_s=wall, steady_s=wall, rate_hz=10.0, queue_frames=QUEUE, clients=20, each=20)

    async def main() -> None:
        panels = {Panel(hub): ADMIN, Panel(hub, OPERATOR): OPERATOR}
        async for step in seconds(plant, projection, 300):
            wall.now_s += 1.0
            projection.look(wall.now_s)
            hub.tick()
            for panel, who in panels.items():
                await panel.read_all()
                if step % 10 == 9:
                    known = everything(hub, who)
                    assert {kind: panel.seen[kind] for kind in known} == known, step
        assert [panel.snapshots for panel in panels] == [1, 1]

    run(main())


@pytest.mark.parametrize("portion", [1, PORTION])
def test_panels_of_every_pace_see_what_the_gateway_knows_while_a_factory_runs(
    portion: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Panels come at some time, some read late, and at the end all of them show the same as the projection, however little a frame holds."""
    monkeypatch.setattr(stream_module, "PORTION", portion)
    plant, chance, wall = default_plant(), Random(7), Wall()
    projection = Projection(plant.file, TimeScale(0.0, NOW_S))
    hub = Hub(projection, wall_s=wall, steady_s=wall, rate_hz=10.0, queue_frames=QUEUE, clients=20, each=20)

    async def main() -> list[Panel]:
        panels: list[Panel] = []
        async for step in seconds(plant, projection, 300):
            wall.now_s += 1.0 if step % 2 else 0.1
            if step % 75 == 0:
                panels += (Panel(hub), Panel(hub, pace=Pace.CALM), Panel(hub, OPERATOR))
            projection.look(wall.now_s)
            hub.tick()
            for panel in panels:
                if chance.random() < 0.3:
                    await panel.read_all()
        for _ in range(1 + (len(projection.tasks.ids()) + len(projection.orders.ids())) // portion):
            wall.now_s += QUIET_S
            hub.tick()
            for panel in panels:
                await panel.read_all()
        return panels

    panels = run(main())
    whole, area = everything(hub, ADMIN), everything(hub, OPERATOR)
    assert all(whole[kind] for kind in ("atv", "machine", "station", "task"))
    assert any(panel.snapshots > 1 for panel in panels)
    for panel in panels:
        known = area if panel.client.owner == "person:operator" else whole
        for kind, seen in panel.seen.items():
            assert seen == known[kind], kind


class Stage:
    """A projection, a hub and a wall clock, without a server."""

    def __init__(self) -> None:
        self.wall, self.steady = Wall(), Wall()
        self.projection = Projection(PLANT, TimeScale(0.0, NOW_S))
        self.hub = Hub(
            self.projection,
            wall_s=self.wall,
            steady_s=self.steady,
            rate_hz=10.0,
            queue_frames=QUEUE,
            clients=10,
            each=10,
        )
        self.seq = 0

    def tell(self, *messages: Message, passes_s: float = 0.1) -> None:
        for message in messages:
            self.projection.fold(message)
        self.wall.now_s += passes_s
        self.steady.now_s += abs(passes_s)
        self.hub.tick()

    def beat(self, passes_s: float = 0.1, **fields: Any) -> None:
        self.seq += 1
        self.tell(atv_heartbeat(seq=self.seq, at_s=float(self.seq), **fields), passes_s=passes_s)


async def frames(client: Client) -> list[dict[str, Any]]:
    """All that wait for a client."""
    return [json.loads(await client.next_frame()) for _ in range(len(client._frames) + client._lost)]


def test_a_delta_tells_the_id_of_an_entity_and_what_has_changed() -> None:
    async def main() -> None:
        stage = Stage()
        client = stage.hub.join(ADMIN)
        assert client is not None
        stage.beat()
        await frames(client)
        stage.beat(
            speed_mps=0.5
        )  # The first after a snapshot tells it whole: others may know an older state.
        stage.beat(speed_mps=1.5)
        first, second = await frames(client)
        assert len(first["atvs"][0]) > 20
        assert set(second["atvs"][0]) == {"id", "speed_mps", "seen_at_s"}
        assert second["atvs"][0]["speed_mps"] == 1.5

    run(main())


def test_what_has_changed_twice_since_a_snapshot_is_told_to_whoever_has_it() -> None:
    async def main() -> None:
        stage = Stage()
        early = Panel(stage.hub)
        stage.beat(speed_mps=1.0)
        await early.read_all()
        stage.beat(speed_mps=1.0)
        await early.read_all()
        stage.seq += 1
        stage.projection.fold(atv_heartbeat(seq=stage.seq, speed_mps=2.0))
        late = Panel(stage.hub)
        await late.read_all()
        assert late.seen["atv"]["ATV1"]["speed_mps"] == 2.0
        # Back to what the first panel was told last: for it nothing has changed, for the other one it has.
        stage.beat(speed_mps=1.0)
        for panel in (early, late):
            await panel.read_all()
            assert panel.seen["atv"]["ATV1"]["speed_mps"] == 1.0

    run(main())


def test_a_calm_panel_is_told_once_a_second_what_has_changed_since() -> None:
    async def main() -> None:
        stage = Stage()
        client = stage.hub.join(ADMIN, Pace.CALM)
        assert client is not None
        stage.beat()
        await frames(client)
        told = []
        for step in range(1, 13):
            stage.beat(speed_mps=float(step), passes_s=QUIET_S / 4)
            told += await frames(client)
        assert [frame["atvs"][0]["speed_mps"] for frame in told] == [4.0, 8.0, 12.0]

    run(main())


def test_a_panel_that_is_too_slow_is_told_calmly_for_a_while_and_then_as_before() -> None:
    async def main() -> None:
        stage = Stage()
        slow, quick = Panel(stage.hub), Panel(stage.hub)
        await slow.read_all()
        for _ in range(QUEUE + 1):
            await quick.read_all()
            stage.beat()
        assert slow.client.room is not quick.client.room
        await slow.read_all()
        for _ in range(9):
            stage.beat()
            await quick.read_all()
        before = slow.number
        await slow.read_all()
        assert (slow.snapshots, quick.snapshots) == (2, 1)
        assert slow.number <= before + 1
        stage.beat(passes_s=CALM_S)
        stage.beat()
        assert slow.client.room is quick.client.room
        for panel in (slow, quick):
            await panel.read_all()
        assert slow.seen == quick.seen
        stage.hub.leave(slow.client)
        stage.hub.leave(quick.client)
        assert stage.hub.joined == 0

    run(main())


def test_a_clock_that_is_set_back_keeps_nobody_slow() -> None:
    async def main() -> None:
        stage = Stage()
        slow, quick = Panel(stage.hub), Panel(stage.hub)
        await slow.read_all()
        for _ in range(QUEUE + 1):
            await quick.read_all()
            stage.beat()
        stage.beat(passes_s=-3600.0)
        assert slow.client.room is quick.client.room

    run(main())


def test_what_leaves_and_comes_back_within_a_second_is_there_for_a_calm_panel() -> None:
    async def main() -> None:
        stage = Stage()
        panel = Panel(stage.hub, pace=Pace.CALM)
        await panel.read_all()
        stage.beat(passes_s=QUIET_S)
        changes = stage.projection.atvs.changes
        changes.drop("ATV1")
        stage.tell()
        stage.beat(speed_mps=3.0)
        stage.tell(passes_s=QUIET_S)
        await panel.read_all()
        assert panel.seen["atv"]["ATV1"]["speed_mps"] == 3.0

    run(main())


@pytest.mark.anyio
async def test_of_thousands_a_snapshot_and_each_frame_tell_a_portion_until_all_are_told() -> None:
    stage, count = Stage(), 3 * PORTION + 1
    for number in range(count):
        stage.projection.orders.put(placed(number))
    stage.projection.discard_changes()
    panel = Panel(stage.hub)
    await panel.read_all()
    told = [len(panel.seen["order"])]
    while told[-1] < count:
        stage.tell()
        (frame,) = await frames(panel.client)
        panel._take(frame)
        told.append(len(panel.seen["order"]))
    assert told == [PORTION, 2 * PORTION, 3 * PORTION, count]
    late = Panel(stage.hub)
    await late.read_all()
    for number in range(count):
        stage.projection.orders.put(replace(placed(number), customer="another"))
    for _ in range(8):
        stage.tell()
        before = len(panel.client._frames)
        assert before <= 1
        for each in (panel, late):
            for frame in await frames(each.client):
                assert len(frame["orders"]) <= PORTION
                each._take(frame)
    assert panel.seen["order"] == late.seen["order"] == everything(stage.hub, ADMIN)["order"]
    assert {order["customer"] for order in panel.seen["order"].values()} == {"another"}


def placed(number: int) -> Order:
    item = Item("gear-unit-g1", 5)
    return Order(
        id=f"O-{number}", status=OrderStatus.STORED, customer="c", token="t", items=(item,), created_at_s=1.0
    )
