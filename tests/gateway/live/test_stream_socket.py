"""The stream's websocket: who is let in, what may be said, and how it is closed."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator
from typing import Any

import pytest
from gateway_kit import PRODUCT, House, draft, gateway
from heartbeats import atv_heartbeat, events
from makings import ANY
from msgspec.structs import replace
from stream_sockets import Socket, opened
from wall_clock import NOW_S

from dray.gateway.access.gate import COOKIE
from dray.gateway.access.principal import ADMIN, Principal, Role, Scope
from dray.gateway.live.stream import Hub
from dray.gateway.live.stream_scopes import FactoryScope
from dray.gateway.live.visibility import FactoryVisibility
from dray.gateway.routes.stream import INCOMING_MESSAGES, POLICY, TRY_LATER
from dray.messages import Pose, Production
from dray.messages import Role as Part
from dray.messages.fact import GoalLost, TaskOpened

PATIENCE_S = 60.0

pytestmark = pytest.mark.anyio

QUEUE = 4
"""Frames that wait for a client here."""


NEVER_HZ = 1e-6
"""Frames are made when the test says so."""


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


async def test_no_name_in_the_stream_tells_of_an_order_who_may_not_read_them(still: House) -> None:
    """A goal has its order's name in its own: as a task, at its machine, in news, and when it is gone."""
    order, goal = "O-1M9K3X2A4-K7QM", "O-1M9K3X2A4-K7QM-1.1"
    hub, projection = still.hub, still.projection
    client = hub.join(Principal(kind="key", id="k", name="Display", scopes=frozenset({Scope.FACTORY_READ})))
    assert client is not None
    frames = [await client.next_frame()]
    work = Production(PRODUCT, 5, order, 0, ANY)
    opened = TaskOpened(goal, 1, Part.PRIMARY, 1, work, 0.0, 900.0, 2.0)
    lost = GoalLost(goal, "M1", 0, f"{order}-1.2")
    for event in events("strategist", opened, lost):
        still.bus.say(event)
    hub.tick()
    frames.append(await client.next_frame())
    told = json.loads(frames[-1])
    [task], [news] = told["tasks"], told["news"]
    assert task["id"].startswith("goal-")
    assert (news["id"], news["goal"]) == (f"lost-{task['id']}", task["id"])
    assert news["successor"] not in ("", task["id"])
    assert FactoryScope(projection, FactoryVisibility(projection.site)).delta(
        replace(projection.delta(1, NOW_S, None), gone=(f"task:{goal}", f"news:lost-{goal}", "atv:ATV1"))
    ).gone == (f"task:{task['id']}", f"news:lost-{task['id']}", "atv:ATV1")
    assert "O-1M9K3X2A4" not in "".join(frames)
    _, header = await still.key(Scope.FACTORY_READ)
    display = still.visitor(**header)
    assert (await display.get(f"/api/tasks/{task['id']}")).json()["id"] == task["id"]
    assert (await display.get(f"/api/tasks/{goal}")).status_code == 404
    assert "O-1M9K3X2A4" not in (await display.get("/api/tasks")).text
    assert (await still.client.get(f"/api/tasks/{goal}")).json()["order"] == order
    await still.historian.written()
    kept = (await still.get("/api/tasks/history"))["items"]
    assert [(each["id"], each["order"]) for each in kept] == [(goal, order)]
    [record] = (await display.get("/api/tasks/history")).json()["items"]
    assert (record["id"], record["order"], record["reference"]) == (task["id"], "", None)
    assert "O-1M9K3X2A4" not in (await display.get("/api/tasks/history", params={"format": "csv"})).text
    asked = await display.get("/api/tasks/history", params={"order": order})
    assert asked.status_code == 403


async def test_one_caller_has_so_many_streams_and_leaves_places_to_others(still: House) -> None:
    projection = still.projection
    hub = Hub(
        projection,
        wall_s=still.wall,
        steady_s=still.wall,
        rate_hz=10.0,
        queue_frames=QUEUE,
        clients=200,
        each=2,
    )
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


async def gone(before: set[asyncio.Task[Any]]) -> None:
    """Wait until no task is left that there was not before: the database takes a moment to close a connection."""
    if more := asyncio.all_tasks() - before:
        _, left = await asyncio.wait(more, timeout=PATIENCE_S)
        assert not left


async def test_a_browser_that_leaves_leaves_nothing_behind(still: House) -> None:
    tasks = asyncio.all_tasks()
    async with opened(still) as socket:
        await socket.read()
        assert still.hub.joined == 1
    assert still.hub.joined == 0
    await gone(tasks)


async def test_a_browser_that_leaves_while_it_is_sent_to_leaves_nothing_behind(still: House) -> None:
    tasks = asyncio.all_tasks()
    async with opened(still) as socket:
        await socket.read()
        socket.takes.clear()
        still.bus.say(atv_heartbeat())
        still.hub.tick()
    assert still.hub.joined == 0
    await gone(tasks)


async def test_one_browser_too_many_is_asked_to_come_later(still: House) -> None:
    async with opened(still), opened(still):
        refused = Socket(still)
        # Browsers hide the status of a refused handshake: the socket opens, and its close says why.
        assert (await refused.from_app.get())["type"] == "websocket.accept"
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
