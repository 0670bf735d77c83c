"""The guard of a listener: how many may be connected, and how long they may keep us waiting."""

from __future__ import annotations

import asyncio
import contextlib
import resource
from typing import Any

import pytest
from uvicorn.protocols.http.h11_impl import H11Protocol

from dray.cli.runtime.gateway.guard import BODY_S, HEAD_S, SPARE_FILES, STALL_S, Guard, room_for
from dray.cli.runtime.gateway.serving import Server
from dray.cli.runtime.listener import listen
from dray.settings import Settings


class Line(asyncio.Transport):
    """A connection that is only looked at."""

    def __init__(self, address: str) -> None:
        super().__init__({"peername": (address, 40_000)})
        self.ended = False
        self.unsent = 0

    def abort(self) -> None:
        self.ended = True

    def get_write_buffer_size(self) -> int:
        return self.unsent


class Cycle:
    """A request and its answer."""

    def __init__(self, *, more_body: bool) -> None:
        self.more_body, self.response_complete = more_body, False


class Http(H11Protocol):
    """A connection's protocol, as the guard sees it."""

    def __init__(self) -> None:
        self.cycle: Any = None


class Clock:
    """A clock that goes when it is told to."""

    now_s = 0.0

    def __call__(self) -> float:
        return self.now_s


class Gatehouse:
    """A guard, and those who come."""

    def __init__(self, most: int = 100, each: int = 100, **more: Any) -> None:
        self.clock = Clock()
        self.guard = Guard(most=most, each=each, now_s=self.clock, **more)

    def come(self, address: str = "10.0.0.1", cycle: Cycle | None = None) -> tuple[Line, Http]:
        line, http = Line(address), Http()
        http.cycle = cycle
        self.guard.enter(line, http)
        return line, http

    def wait(self, seconds: float) -> None:
        """Time passes, and the guard looks each second."""
        for _ in range(int(seconds)):
            self.clock.now_s += 1.0
            self.guard.sweep()


def test_a_crowd_that_says_nothing_makes_room_for_whoever_comes() -> None:
    house = Gatehouse(most=8)
    lines = [house.come(f"10.0.{number % 250}.{number // 250}")[0] for number in range(1_100)]
    assert [line.ended for line in lines] == [True] * 1_092 + [False] * 8
    assert house.guard.connected == 8
    assert house.guard.turned_away == 1_092


def test_one_address_has_its_own_bound_and_leaves_the_others_alone() -> None:
    house = Gatehouse(each=4)
    other, _ = house.come("10.0.0.2")
    lines = [house.come("10.0.0.1")[0] for _ in range(20)]
    assert [line.ended for line in lines] == [True] * 16 + [False] * 4
    assert not other.ended


def test_whoever_is_being_answered_keeps_the_place() -> None:
    house = Gatehouse(each=2)
    kept = [house.come(cycle=Cycle(more_body=False))[0] for _ in range(2)]
    late, _ = house.come()
    assert late.ended
    assert not any(line.ended for line in kept)


def test_a_body_that_does_not_come_makes_room_after_those_who_have_not_asked() -> None:
    house = Gatehouse(each=3)
    slow, _ = house.come(cycle=Cycle(more_body=True))
    silent, _ = house.come()
    answered, _ = house.come(cycle=Cycle(more_body=False))
    house.come(cycle=Cycle(more_body=False))
    assert (silent.ended, slow.ended, answered.ended) == (True, False, False)
    house.come(cycle=Cycle(more_body=False))
    assert (slow.ended, answered.ended) == (True, False)


def test_a_network_is_one_address_and_a_proxy_is_none() -> None:
    house = Gatehouse(each=2, exempt=("127.0.0.1", "10.8.0.0/16"))
    first, _ = house.come("2001:db8::1")
    house.come("2001:db8::2")
    house.come("2001:db8::3")
    assert first.ended
    assert not any(house.come("127.0.0.1")[0].ended for _ in range(10))
    assert not any(house.come("10.8.3.4")[0].ended for _ in range(10))


def test_who_has_left_has_left_its_place() -> None:
    house = Gatehouse(each=2)
    first, _ = house.come()
    second, _ = house.come()
    house.guard.leave(first)
    house.guard.leave(first)
    house.come()
    assert not second.ended


def test_a_head_that_does_not_come_ends_its_connection_however_slowly_it_trickles() -> None:
    house = Gatehouse()
    line, _ = house.come()
    house.wait(HEAD_S)
    assert not line.ended
    house.wait(1)
    assert line.ended
    assert house.guard.connected == 0


def test_a_body_that_does_not_come_ends_its_connection() -> None:
    house = Gatehouse()
    line, http = house.come()
    http.cycle = Cycle(more_body=True)
    house.wait(1 + BODY_S)
    assert not line.ended
    house.wait(1)
    assert line.ended


def test_each_request_of_a_connection_has_time_of_its_own() -> None:
    house = Gatehouse()
    line, http = house.come()
    for _ in range(5):
        house.wait(HEAD_S - 2)
        http.cycle = Cycle(more_body=False)
        house.wait(60)  # An answer may take its time.
        http.cycle.response_complete = True
        house.wait(1)
    assert not line.ended


def test_an_answer_that_nobody_takes_is_given_up_and_a_slow_one_is_not() -> None:
    house = Gatehouse()
    slow, _ = house.come(cycle=Cycle(more_body=False))
    stuck, _ = house.come(cycle=Cycle(more_body=False))
    slow.unsent = stuck.unsent = 100_000
    for _ in range(4):
        house.wait(STALL_S - 1)
        house.guard.flows(slow)
    assert not slow.ended
    assert stuck.ended


def test_a_stream_may_be_silent_for_as_long_as_it_likes() -> None:
    house = Gatehouse()
    line, _ = house.come()
    house.guard.enter(line, asyncio.Protocol())
    house.wait(10 * HEAD_S)
    assert not line.ended
    assert house.guard.connected == 1


def test_files_are_left_to_others(monkeypatch: pytest.MonkeyPatch) -> None:
    limits = {"now": (SPARE_FILES + 100, SPARE_FILES + 300)}
    monkeypatch.setattr(resource, "getrlimit", lambda _what: limits["now"])
    monkeypatch.setattr(resource, "setrlimit", lambda _what, both: limits.update(now=both))
    assert room_for(50) == 50
    assert limits["now"][0] == SPARE_FILES + 100
    assert room_for(200) == 200
    assert room_for(1_000) == 300
    assert limits["now"] == (SPARE_FILES + 300, SPARE_FILES + 300)


@pytest.mark.anyio
async def test_a_server_answers_while_a_crowd_holds_half_open_connections() -> None:
    async def app(scope: Any, _receive: Any, send: Any) -> None:
        assert scope["type"] == "http"
        await send({"type": "http.response.start", "status": 204, "headers": []})
        await send({"type": "http.response.body"})

    guard = Guard(most=8, each=8)
    ready = asyncio.Event()
    server = Server(app, Settings.load(), ready.set, guard=guard, streams=False)
    server.config.lifespan = "off"
    with contextlib.closing(listen("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]
        async with asyncio.TaskGroup() as group:
            group.create_task(server.serve(sockets=[listener]))
            await ready.wait()
            crowd = [await asyncio.open_connection("127.0.0.1", port) for _ in range(40)]
            reader, writer = await asyncio.open_connection("127.0.0.1", port)
            writer.write(b"GET / HTTP/1.1\r\nHost: x\r\n\r\n")
            assert (await reader.readline()) == b"HTTP/1.1 204 No Content\r\n"
            # Those who came first have been sent away to make room.
            assert await crowd[0][0].read() == b""
            assert guard.connected == 8
            for _, each in (*crowd, (reader, writer)):
                each.close()
                with contextlib.suppress(ConnectionError):
                    await each.wait_closed()
            server.stop()
