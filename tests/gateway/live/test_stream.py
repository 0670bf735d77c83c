"""The stream: a snapshot and then numbered deltas, for many clients of different speeds."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import msgspec
import pytest
from gateway_kit import BEARER, NOW_S, PLANT, House, Wall, atv_heartbeat, draft, gateway, machine_heartbeat

from dray.gateway.access.gate import COOKIE
from dray.gateway.access.principal import ADMIN, Principal, Role, Scope
from dray.gateway.live.frames import Delta, Snapshot
from dray.gateway.live.projection import Projection
from dray.gateway.live.stream import FACTORY_S, QUIET_S, Client, Hub
from dray.gateway.live.timescale import TimeScale
from dray.gateway.live.views import AudienceView
from dray.gateway.routes.stream import INCOMING_MESSAGES, POLICY, TRY_LATER
from dray.messages import AtvStatus, Pose
from dray_sim.clock.loop import run

pytestmark = pytest.mark.anyio

QUEUE = 4
"""Frames that wait for a client here."""

NEVER_HZ = 1e-6
"""Frames are made when the test says so."""


class Stage:
    """A projection, a hub and a wall clock, without a server."""

    def __init__(self, clients: int = 10) -> None:
        self.wall = Wall()
        self.projection = Projection(PLANT, TimeScale(0.0, NOW_S))
        self.hub = Hub(
            self.projection, wall_s=self.wall, rate_hz=10.0, queue_frames=QUEUE, clients=clients, each=clients
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
        self.atvs |= {atv["id"]: atv for atv in frame["atvs"]}

    async def catch_up(self, client: Client) -> None:
        while not waits(client):
            self.show(await read(client))


# --- what a client is given ----------------------------------------------------------------------


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
    assert encoded == [AudienceView] * 10 + [Snapshot, Delta]
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


# --- slow clients --------------------------------------------------------------------------------


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
    stage.beat()
    await slow_mirror.catch_up(slow)
    await quick_mirror.catch_up(quick)
    assert (slow_mirror.snapshots, slow_mirror.number) == (2, quick_mirror.number)


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


# --- quiet, figures, nobody ----------------------------------------------------------------------


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


async def test_a_wall_clock_that_goes_back_silences_nothing(stage: Stage) -> None:
    client = stage.join()
    stage.hub.tick()
    await read(client)
    stage.wall.now_s -= 3600.0
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
        hub = Hub(projection, wall_s=loop.time, rate_hz=10.0, queue_frames=1000, clients=1, each=1)
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


# --- the websocket -------------------------------------------------------------------------------


class Socket:
    """A browser's end of a websocket, spoken to the application as a server does (ASGI)."""

    def __init__(self, house: House, **headers: str) -> None:
        self.to_app: asyncio.Queue[dict[str, Any]] = asyncio.Queue()
        self.from_app: asyncio.Queue[dict[str, Any]] = asyncio.Queue()
        self.takes = asyncio.Event()
        """Cleared while this browser reads nothing."""
        self.takes.set()
        known = {} if "cookie" in headers else BEARER
        scope = {
            "type": "websocket",
            "asgi": {"version": "3.0"},
            "http_version": "1.1",
            "scheme": "ws",
            "path": "/api/stream",
            "raw_path": b"/api/stream",
            "query_string": b"",
            "root_path": "",
            "headers": [
                (name.lower().encode(), value.encode())
                for name, value in ({"host": "dray.test"} | known | headers).items()
            ],
            "client": ("127.0.0.1", 1234),
            "server": ("dray.test", 80),
            "subprotocols": [],
            "state": {},
        }
        self.to_app.put_nowait({"type": "websocket.connect"})
        self.served = asyncio.create_task(house.app(scope, self.to_app.get, self._send))

    async def _send(self, message: Any) -> None:
        await self.takes.wait()
        await self.from_app.put(message)

    async def read(self) -> dict[str, Any]:
        """The next frame."""
        message = await self.from_app.get()
        assert message["type"] == "websocket.send", message
        frame: dict[str, Any] = json.loads(message["text"])
        return frame

    def say(self, text: str) -> None:
        self.to_app.put_nowait({"type": "websocket.receive", "text": text})

    async def close(self) -> None:
        self.to_app.put_nowait({"type": "websocket.disconnect", "code": 1001})
        await self.served


@asynccontextmanager
async def opened(house: House, **headers: str) -> AsyncIterator[Socket]:
    socket = Socket(house, **headers)
    assert (await socket.from_app.get())["type"] == "websocket.accept"
    yield socket
    await socket.close()


@pytest.fixture
async def still(url: str) -> AsyncIterator[House]:
    """A gateway that makes a frame when the test says so."""
    async with gateway(url, stream_rate_hz=NEVER_HZ, stream_queue_frames=QUEUE, stream_clients=2) as house:
        yield house


async def test_an_operators_browser_is_shown_the_operators_areas(still: House) -> None:
    still.bus.say(
        atv_heartbeat("ATV1", pose=Pose(30.0, 30.0, 0.0)), atv_heartbeat("ATV2", pose=Pose(30.0, 2.0, 0.0))
    )
    operator = await still.log_in("operator-north", Role.OPERATOR, "AREA1")
    async with opened(still, cookie=f"{COOKIE}={operator.cookies[COOKIE]}") as socket:
        frame = await socket.read()
        assert [atv["id"] for atv in frame["atvs"]] == ["ATV1"]
        assert (frame["audience"]["role"], frame["audience"]["areas"]) == ("operator", ["AREA1"])
        still.bus.say(atv_heartbeat("ATV1", 2, pose=Pose(30.0, 2.0, 0.0)))
        still.hub.tick()
        assert (await socket.read())["gone"] == ["atv:ATV1"]


async def test_a_browser_sees_vehicles_and_orders_as_they_come(still: House) -> None:
    still.bus.say(atv_heartbeat())
    still.hub.tick()
    async with opened(still) as socket:
        snapshot = await socket.read()
        assert (snapshot["type"], [atv["id"] for atv in snapshot["atvs"]]) == ("snapshot", ["ATV1"])
        order = (await still.client.post("/api/orders", json=draft())).json()
        still.bus.say(atv_heartbeat("ATV2"))
        still.hub.tick()
        delta = await socket.read()
        assert (delta["type"], delta["number"]) == ("delta", snapshot["number"] + 1)
        assert [atv["id"] for atv in delta["atvs"]] == ["ATV2"]
        assert [seen["id"] for seen in delta["orders"]] == [order["id"]]


async def test_whoever_may_not_read_orders_sees_the_factory_and_nothing_of_its_orders(still: House) -> None:
    still.bus.say(atv_heartbeat("ATV1"))
    order = await still.place(customer="Muster GmbH", reference="4711", due_at="2030-05-01T12:00:00Z")
    hub, projection = still.hub, still.projection
    key = Principal(kind="key", id="k", name="Display", scopes=frozenset({Scope.FACTORY_READ}))
    client, whole = hub.join(key), hub.join(ADMIN)
    assert client is not None
    assert whole is not None
    frames = [await client.next_frame()]
    assert [each["id"] for each in json.loads(await whole.next_frame())["orders"]] == [order["id"]]
    late = await still.place(customer="Muster GmbH", reference="4712", due_at="2030-04-01T12:00:00Z")
    still.bus.say(atv_heartbeat("ATV2"))
    projection.look(NOW_S + 1e8)
    hub.tick()
    told = json.loads(await whole.next_frame())
    assert late["id"] in {each["id"] for each in told["orders"]}
    assert "order_late" in {each["kind"] for each in told["alerts"]}
    frames.append(await client.next_frame())
    assert "ATV2" in {each["id"] for each in json.loads(frames[1])["atvs"]}
    for words in ("Muster", "4711", "4712", order["id"], late["id"], "order_late"):
        assert words not in "".join(frames)


async def test_one_caller_has_so_many_streams_and_leaves_places_to_others(still: House) -> None:
    projection = still.projection
    hub = Hub(projection, wall_s=still.wall, rate_hz=10.0, queue_frames=QUEUE, clients=200, each=2)
    first, second = hub.join(ADMIN), hub.join(ADMIN)
    assert first is not None
    assert second is not None
    assert hub.join(ADMIN) is None
    assert hub.join(Principal(kind="key", id="admin", name="Display", scopes=frozenset())) is not None
    for _ in range(2):
        hub.leave(first)
    assert hub.join(ADMIN) is not None
    assert hub.join(ADMIN) is None


async def test_no_frame_holds_the_secret_of_a_customers_page(still: House) -> None:
    order = (await still.client.post("/api/orders", json=draft())).json()
    token = order["tracking_url"].rpartition("/")[2]
    async with opened(still) as socket:
        assert token not in json.dumps(await socket.read())


async def test_a_browser_that_reads_nothing_does_not_slow_another(still: House) -> None:
    async with opened(still) as slow, opened(still) as quick:
        await slow.read()
        await quick.read()
        slow.takes.clear()
        for seq in range(1, 4 * QUEUE):
            still.bus.say(atv_heartbeat(seq=seq, speed_mps=float(seq)))
            still.hub.tick()
            assert (await quick.read())["atvs"][0]["speed_mps"] == seq
        slow.takes.set()
        # The frame that was on its way when it stopped reading, and then everything at once.
        assert (await slow.read())["type"] == "delta"
        fresh = await slow.read()
        assert (fresh["type"], fresh["atvs"][0]["speed_mps"]) == ("snapshot", 4 * QUEUE - 1)


async def test_some_words_of_a_browser_are_ignored(still: House) -> None:
    async with opened(still) as socket:
        await socket.read()
        for _ in range(INCOMING_MESSAGES - 1):
            socket.say('{"type": "delta"}')
        still.bus.say(atv_heartbeat())
        still.hub.tick()
        assert (await socket.read())["type"] == "delta"


async def test_a_browser_that_talks_and_talks_is_shown_out(still: House) -> None:
    socket = Socket(still)
    for _ in range(INCOMING_MESSAGES):
        socket.say("x")
    await socket.served
    told = [socket.from_app.get_nowait() for _ in range(socket.from_app.qsize())]
    assert (told[-1]["type"], told[-1]["code"]) == ("websocket.close", POLICY)
    assert still.hub.joined == 0


async def test_a_browser_that_leaves_leaves_nothing_behind(still: House) -> None:
    tasks = asyncio.all_tasks()
    async with opened(still) as socket:
        await socket.read()
        assert still.hub.joined == 1
    assert still.hub.joined == 0
    assert asyncio.all_tasks() == tasks


async def test_a_browser_that_leaves_while_it_is_sent_to_leaves_nothing_behind(still: House) -> None:
    tasks = asyncio.all_tasks()
    async with opened(still) as socket:
        await socket.read()
        socket.takes.clear()
        still.bus.say(atv_heartbeat())
        still.hub.tick()
    assert still.hub.joined == 0
    assert asyncio.all_tasks() == tasks


async def test_one_browser_too_many_is_asked_to_come_later(still: House) -> None:
    async with opened(still), opened(still):
        refused = Socket(still)
        message = await refused.from_app.get()
        assert (message["type"], message["code"]) == ("websocket.close", TRY_LATER)
        await refused.served
    async with opened(still) as welcome:
        assert (await welcome.read())["type"] == "snapshot"


async def test_another_sites_page_may_not_watch(still: House) -> None:
    stranger = Socket(still, origin="https://elsewhere.test")
    assert (await stranger.from_app.get())["type"] == "websocket.close"
    await stranger.served
    assert still.hub.joined == 0
