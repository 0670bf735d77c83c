"""A link ends, and is joined again, whatever its client was doing at that moment.

The client waits with `asyncio.wait_for`, which swallows a cancellation that comes in the same turn as what it waits for; and an
error of its own end takes the place of a cancellation. Both once made a link that never ended, and one that was never joined again.
"""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncIterator, Callable
from typing import Any, Self

import aiomqtt
import pytest

from dray.adapters.vda5050 import link as link_module
from dray.adapters.vda5050.link import BrokerAddress, MqttLink
from dray.errors import ProtocolViolation, UnavailableError

PATIENCE_S = 20.0
"""Far beyond what a busy computer takes."""


class Client:
    """A broker's client that says what it is told when the test lets it."""

    def __init__(self) -> None:
        self.saying, self.said = asyncio.Event(), asyncio.Event()
        self.subscribing, self.subscribed = asyncio.Event(), asyncio.Event()
        self.gone = asyncio.Event()
        self.brings: tuple[str, ...] = ()
        self.end: Exception | None = None

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_error: object) -> None:
        if self.end is not None:
            raise self.end

    async def subscribe(self, _topic: str, qos: int) -> None:
        self.subscribing.set()
        await asyncio.wait_for(self.subscribed.wait(), PATIENCE_S)

    async def publish(self, *_what: object, **_how: object) -> None:
        self.saying.set()
        await asyncio.wait_for(self.said.wait(), PATIENCE_S)

    @property
    async def messages(self) -> AsyncIterator[Any]:
        for topic in self.brings:
            yield aiomqtt.Message(f"uagv/v2/Yard/1/{topic}", b"{}", 0, False, 1, None)
        await self.gone.wait()
        raise aiomqtt.MqttError("reset by peer")
        yield


class Ear:
    def __init__(self) -> None:
        self.links = asyncio.Queue[int]()
        self.lost: list[str] = []
        self.heard: list[str] = []
        self.all_heard = asyncio.Event()
        self.fails: dict[str, Exception] = {}

    def on_link(self) -> None:
        self.links.put_nowait(1)

    def on_link_lost(self, reason: str) -> None:
        self.lost.append(reason)

    def on_message(self, topic: str, data: bytes) -> None:
        self.heard.append(topic)
        self.all_heard.set() if topic == "factsheet" else None
        if (error := self.fails.get(topic)) is not None:
            raise error


class Play:
    """One link and the clients it made."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, *topics: str) -> None:
        self.clients: list[Client] = []
        self.brings: tuple[str, ...] = ()
        monkeypatch.setattr(link_module.aiomqtt, "Client", self._make)
        monkeypatch.setattr(link_module, "AGAIN_S", (0.0,))
        self.link = MqttLink(BrokerAddress("h", 1, tls=False), "uagv/v2/Yard/1", "us", topics)
        self.ear = Ear()
        self.task = asyncio.create_task(self.link.run(self.ear))

    def _make(self, *_what: object, **_how: object) -> Client:
        self.clients.append(Client())
        self.clients[-1].brings = self.brings
        return self.clients[-1]

    async def ends(self) -> bool:
        await asyncio.wait([self.task], timeout=PATIENCE_S)
        ended = self.task.cancelled()
        while not self.task.done():
            self.task.cancel()
            await asyncio.sleep(0)
        return ended


def played(play: Callable[[], Any]) -> None:
    async def main() -> None:
        async with asyncio.timeout(3 * PATIENCE_S):
            await play()

    asyncio.run(main())


def test_a_link_ends_though_something_was_said_in_the_same_turn(monkeypatch: pytest.MonkeyPatch) -> None:
    async def play() -> None:
        at = Play(monkeypatch)
        await at.ear.links.get()
        at.link.publish("order", b"go")
        await at.clients[0].saying.wait()
        at.clients[0].said.set()
        at.task.cancel()
        assert await at.ends()

    played(play)


def test_a_link_that_is_lost_while_something_is_said_is_joined_again(monkeypatch: pytest.MonkeyPatch) -> None:
    async def play() -> None:
        at = Play(monkeypatch)
        await at.ear.links.get()
        at.link.publish("order", b"go")
        await at.clients[0].saying.wait()
        at.clients[0].said.set()
        at.clients[0].gone.set()
        await at.ear.links.get()
        assert len(at.clients) == 2
        assert at.ear.lost == ["mqtt://h:1: reset by peer"]
        at.task.cancel()
        assert await at.ends()

    played(play)


def test_a_link_ends_though_its_topics_were_subscribed_to_in_the_same_turn(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async def play() -> None:
        at = Play(monkeypatch, "state")
        await asyncio.sleep(0)  # The link makes its client.
        await at.clients[0].subscribing.wait()
        at.clients[0].subscribed.set()
        await asyncio.sleep(0)  # What is waited for is there; who waits has not been told yet.
        at.task.cancel()
        assert await at.ends()
        assert at.ear.links.empty()

    played(play)


def test_a_link_ends_though_its_broker_is_lost_while_it_says_good_bye(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async def play() -> None:
        at = Play(monkeypatch)
        await at.ear.links.get()
        at.clients[0].end = aiomqtt.MqttError("reset by peer")
        at.task.cancel()
        assert await at.ends()
        assert len(at.clients) == 1
        assert at.ear.lost == []

    played(play)


@pytest.mark.parametrize(
    "error",
    [KeyError("state"), ValueError("no number"), ProtocolViolation("of ours"), RecursionError("deep")],
)
def test_a_message_that_its_listener_cannot_deal_with_is_counted_and_told_and_the_next_is_heard(
    error: Exception, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    async def play() -> None:
        at = Play(monkeypatch)
        at.link = MqttLink(BrokerAddress("h", 1, tls=False), "uagv/v2/Yard/1", "us", ("state",))
        at.task.cancel()
        await asyncio.wait([at.task])
        at.brings = ("state", "state", "odd", "factsheet")
        at.ear.fails = {"state": error, "odd": error}
        at.task = asyncio.create_task(at.link.run(at.ear))
        await asyncio.sleep(0)  # The link makes its client.
        at.clients[0].subscribed.set()
        await at.ear.all_heard.wait()
        assert at.ear.heard == ["state", "state", "odd", "factsheet"]
        assert at.link.failures.counts == {"state": 2, "another topic": 1}
        assert not at.ear.lost
        assert not at.task.done()
        at.task.cancel()
        assert await at.ends()

    with caplog.at_level(logging.ERROR, "dray.supervision"):
        played(play)
    assert "uagv/v2/Yard/1: state has failed" in caplog.text
    assert {record.levelno for record in caplog.records} == {logging.ERROR}


def test_a_link_ends_when_its_listener_cannot_write_down_what_it_is_bound_by(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async def play() -> None:
        at = Play(monkeypatch)
        at.brings = ("state",)
        at.ear.fails = {"state": UnavailableError("the disk", "is full", "make room")}
        with pytest.raises(UnavailableError, match="the disk"):
            await at.task
        assert not at.link.failures.counts

    played(play)
