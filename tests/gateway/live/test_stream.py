"""The stream: a snapshot and then numbered deltas, for many clients of different speeds."""

from __future__ import annotations

import asyncio
import json
import re
from pathlib import Path
from typing import Any

import msgspec
import pytest
from fake_bus import PLANT
from heartbeats import atv_heartbeat, machine_heartbeat
from wall_clock import NOW_S, Wall

from dray.gateway.access.principal import ADMIN
from dray.gateway.live.frames import COLLECTIONS, Snapshot
from dray.gateway.live.projection import Projection
from dray.gateway.live.stream import FACTORY_S, QUIET_S, Client, Hub
from dray.gateway.live.timescale import TimeScale
from dray.gateway.live.views import AudienceView
from dray.messages import AtvStatus
from dray_sim.clock.loop import run

pytestmark = pytest.mark.anyio

QUEUE = 4
"""Frames that wait for a client here."""

WORLD = Path(__file__).parents[3] / "frontend" / "src" / "stream" / "world.ts"
"""The stream as panels read it."""


class Stage:
    """A projection, a hub and a wall clock, without a server."""

    def __init__(self, clients: int = 10) -> None:
        self.wall = Wall()
        self.projection = Projection(PLANT, TimeScale(0.0, NOW_S))
        self.hub = Hub(
            self.projection,
            wall_s=self.wall,
            steady_s=self.wall,
            rate_hz=10.0,
            queue_frames=QUEUE,
            clients=clients,
            each=clients,
        )
        self.seq = 0

    def join(self) -> Client:
        client = self.hub.join(ADMIN)
        assert client is not None
        return client

    def beat(self, **fields: Any) -> None:
        """A vehicle says something new, and a frame is made of it."""
        self.seq += 1
        self.projection.fold(atv_heartbeat(seq=self.seq, **fields))
        self.hub.tick()


@pytest.fixture
def stage() -> Stage:
    return Stage()


async def read(client: Client) -> dict[str, Any]:
    frame: dict[str, Any] = json.loads(await client.next_frame())
    return frame


def waits(client: Client) -> bool:
    """Whether there is nothing for this client at this moment."""
    return not client._ready.is_set()


class Mirror:
    """What a panel makes of its frames: entities by kind and id, and no gap in the numbers."""

    def __init__(self) -> None:
        self.number = -1
        self.atvs: dict[str, Any] = {}
        self.snapshots = 0

    def show(self, frame: dict[str, Any]) -> None:
        if frame["type"] == "snapshot":
            self.snapshots += 1
            self.atvs = {}
        else:
            assert frame["number"] == self.number + 1
        self.number = frame["number"]
        self.atvs |= {atv["id"]: self.atvs.get(atv["id"], {}) | atv for atv in frame["atvs"]}

    async def catch_up(self, client: Client) -> None:
        while not waits(client):
            self.show(await read(client))


# --- what a client is given -------------------------------------------------------------------------


async def test_a_client_gets_a_snapshot_first_and_then_deltas_without_a_gap(stage: Stage) -> None:
    early = stage.join()
    for _ in range(3):
        stage.beat()
    client = stage.join()
    frames = [await read(client)]
    for _ in range(3):
        stage.beat()
        frames.append(await read(client))
    assert [frame["type"] for frame in frames] == ["snapshot", "delta", "delta", "delta"]
    assert [frame["number"] for frame in frames] == [3, 4, 5, 6]
    assert frames[0]["plant"] == PLANT.plant
    assert [atv["id"] for atv in frames[0]["atvs"]] == ["ATV1"]
    assert early is not client


async def test_what_changed_between_the_frames_and_a_snapshot_is_never_missed(stage: Stage) -> None:
    first = stage.join()
    stage.beat()
    await read(first)
    # The snapshot of this frame is kept for the next client, and what comes now is not in it.
    stage.projection.fold(atv_heartbeat("ATV2"))
    late, mirror = stage.join(), Mirror()
    await mirror.catch_up(late)
    stage.hub.tick()
    await mirror.catch_up(late)
    assert set(mirror.atvs) == {"ATV1", "ATV2"}


async def test_a_client_waits_for_the_next_frame(stage: Stage) -> None:
    client = stage.join()
    await read(client)
    waiting = asyncio.create_task(read(client))
    await asyncio.sleep(0)
    assert not waiting.done()
    stage.beat()
    assert (await waiting)["type"] == "delta"


async def test_a_frame_is_encoded_once_for_all_clients(stage: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
    encoded: list[type] = []
    real = msgspec.json.Encoder()

    class Counting:
        def encode(self, value: object) -> bytes:
            encoded.append(type(value))
            return real.encode(value)

    monkeypatch.setattr("dray.gateway.live.stream._encoder", Counting())
    clients = [stage.join() for _ in range(10)]
    snapshots = [await client.next_frame() for client in clients]
    stage.beat()
    deltas = [await client.next_frame() for client in clients]
    assert encoded == [AudienceView] * 10 + [Snapshot, dict]
    assert len(set(snapshots)) == 1
    assert all(frame is deltas[0] for frame in deltas)


async def test_a_delta_tells_only_what_has_changed(stage: Stage) -> None:
    client = stage.join()
    stage.projection.fold(machine_heartbeat())
    stage.beat()
    await read(client)
    stage.beat(speed_mps=1.5)
    frame = await read(client)
    assert [atv["speed_mps"] for atv in frame["atvs"]] == [1.5]
    assert (frame["machines"], frame["tasks"], frame["orders"], frame["gone"]) == ([], [], [], [])


# --- slow clients -----------------------------------------------------------------------------------


async def test_a_slow_client_gets_a_fresh_snapshot_and_another_one_never_notices(stage: Stage) -> None:
    slow, quick = stage.join(), stage.join()
    slow_mirror, quick_mirror = Mirror(), Mirror()
    await slow_mirror.catch_up(slow)
    for step in range(3 * QUEUE):
        stage.beat(speed_mps=float(step))
        assert len(slow._frames) <= QUEUE
        quick_mirror.show(await read(quick))
    await slow_mirror.catch_up(slow)
    assert (slow_mirror.snapshots, slow.snapshots) == (2, 2)
    assert (quick_mirror.snapshots, quick_mirror.number) == (1, 3 * QUEUE)
    assert slow_mirror.atvs == quick_mirror.atvs
    assert slow_mirror.atvs["ATV1"]["speed_mps"] == 3 * QUEUE - 1
    stage.wall.now_s += QUIET_S
    stage.beat()
    await slow_mirror.catch_up(slow)
    await quick_mirror.catch_up(quick)
    assert slow_mirror.snapshots == 2
    assert slow_mirror.atvs == quick_mirror.atvs


async def test_a_full_queue_that_is_read_in_time_loses_nothing(stage: Stage) -> None:
    client, mirror = stage.join(), Mirror()
    await mirror.catch_up(client)
    for _ in range(QUEUE):
        stage.beat()
    await mirror.catch_up(client)
    assert (mirror.snapshots, mirror.number) == (1, QUEUE)


async def test_a_client_that_reads_nothing_holds_no_frames(stage: Stage) -> None:
    client = stage.join()
    for _ in range(100):
        stage.beat()
    assert len(client._frames) == 0
    assert (await read(client))["number"] == 100


# --- quiet, figures, nobody -------------------------------------------------------------------------


async def test_an_empty_delta_keeps_a_quiet_stream_alive(stage: Stage) -> None:
    client = stage.join()
    stage.hub.tick()
    await read(client)
    stage.wall.now_s += 0.9 * QUIET_S
    stage.hub.tick()
    assert waits(client)
    stage.wall.now_s += 0.1 * QUIET_S
    stage.hub.tick()
    frame = await read(client)
    assert (frame["type"], frame["atvs"], frame["tasks"]) == ("delta", [], [])


@pytest.mark.parametrize("by_s", [-3600.0, 0.0], ids=["goes-back", "stands"])
async def test_a_wall_clock_that_does_not_go_on_silences_nothing(by_s: float) -> None:
    stage, steady = Stage(), Wall()
    stage.hub = Hub(
        stage.projection, wall_s=stage.wall, steady_s=steady, rate_hz=10.0, queue_frames=1, clients=1, each=1
    )
    client = stage.join()
    stage.hub.tick()
    await read(client)
    stage.wall.now_s += by_s
    steady.now_s += 0.9 * QUIET_S
    stage.hub.tick()
    assert waits(client)
    steady.now_s += 0.1 * QUIET_S
    stage.hub.tick()
    assert not waits(client)


async def test_the_figures_come_when_they_have_changed_and_at_most_once_a_second(stage: Stage) -> None:
    client = stage.join()
    await read(client)
    told = []
    for status in (AtvStatus.IDLE, AtvStatus.WORKING, AtvStatus.WORKING, AtvStatus.WORKING):
        stage.beat(status=status)
        told.append((await read(client))["factory"])
        stage.wall.now_s += 0.5 * FACTORY_S
    assert [factory and factory["atvs_by_status"] for factory in told] == [
        {"idle": 1},
        None,
        {"working": 1},
        None,
    ]


async def test_figures_that_only_a_snapshot_has_told_are_told_again(stage: Stage) -> None:
    first = stage.join()
    stage.beat(status=AtvStatus.IDLE)
    await read(first)
    stage.hub.leave(first)
    stage.beat(status=AtvStatus.WORKING)
    client = stage.join()
    assert (await read(client))["factory"]["atvs_by_status"] == {"working": 1}
    stage.wall.now_s += FACTORY_S
    stage.beat(status=AtvStatus.IDLE)
    assert (await read(client))["factory"]["atvs_by_status"] == {"idle": 1}


async def test_while_nobody_looks_no_frame_is_made(stage: Stage) -> None:
    stage.beat()
    assert not stage.projection.changed
    client = stage.join()
    frame = await read(client)
    assert (frame["number"], len(frame["atvs"])) == (0, 1)


async def test_a_client_after_a_time_without_clients_sees_what_happened_meanwhile(stage: Stage) -> None:
    gone = stage.join()
    stage.beat()
    await read(gone)
    stage.hub.leave(gone)
    stage.hub.leave(gone)
    stage.beat(speed_mps=1.0)
    client, mirror = stage.join(), Mirror()
    await mirror.catch_up(client)
    stage.beat(speed_mps=2.0)
    await mirror.catch_up(client)
    assert mirror.atvs["ATV1"]["speed_mps"] == 2.0


async def test_there_is_room_for_so_many_clients_and_no_more() -> None:
    stage = Stage(clients=2)
    first, _ = stage.join(), stage.join()
    assert stage.hub.join(ADMIN) is None
    stage.hub.leave(first)
    assert stage.hub.join(ADMIN) is not None


def test_frames_are_made_at_the_rate_that_was_asked_for_however_much_happens() -> None:
    async def main() -> int:
        loop = asyncio.get_running_loop()
        projection = Projection(PLANT, TimeScale(0.0, 0.0))
        hub = Hub(
            projection,
            wall_s=loop.time,
            steady_s=loop.time,
            rate_hz=10.0,
            queue_frames=1000,
            clients=1,
            each=1,
        )
        client = hub.join(ADMIN)
        assert client is not None
        await client.next_frame()
        making = asyncio.create_task(hub.run())
        for seq in range(1, 1001):
            projection.fold(atv_heartbeat(seq=seq))
            await asyncio.sleep(0.002)
        making.cancel()
        return len(client._frames)

    # Two seconds of virtual time.
    assert run(main()) in (19, 20)


def test_panels_know_every_kind_of_entity_by_its_name() -> None:
    told = WORLD.read_text(encoding="utf-8").partition("export const COLLECTIONS = {")[2].partition("}")[0]
    assert dict(re.findall(r'(\w+): "(\w+)"', told)) == COLLECTIONS
