"""A bus beside itself: an agent of the same process and certificate on another thread's loop."""

from __future__ import annotations

import asyncio
import threading
from concurrent.futures import Future
from pathlib import Path

import pytest
from zenoh_kit import PATIENCE_S, Row

from dray.adapters.security.certificates import Authority
from dray.adapters.security.identity import Identity
from dray.adapters.security.signing import SigningKey
from dray.adapters.zenoh.bus import ZenohBus
from dray.gateway.access.principal import ADMIN
from dray.gateway.live.timescale import TimeScale
from dray.gateway.stop.sender import StopSender
from dray.messages import CommandAnswered, Message, VehicleCommand
from dray.messages.kinds import Kind
from dray.messages.speakers import names_of, stop_sender_of


@pytest.fixture
def row_of(tmp_path: Path) -> list[Identity]:
    """The certificates of a vehicle and of a gateway, which has its sender's name as well."""
    authority = Authority.make("p")
    authority.write(tmp_path)
    authority.issue(tmp_path, "p", names_of("ATV1", Kind.ATV))
    authority.issue(tmp_path, "p", names_of("gateway", Kind.GATEWAY))
    return [Identity.in_folder(tmp_path, name) for name in ("ATV1", "gateway")]


def obeying(bus: ZenohBus) -> None:
    """A vehicle that obeys."""

    def receive(sender: str, message: Message) -> None:
        if isinstance(message, VehicleCommand):
            vehicle.send(sender, CommandAnswered(command=message.command, done=True))

    vehicle = bus.join("ATV1", receive, 1)


def desk_on(bus: ZenohBus, begun: Future[asyncio.AbstractEventLoop], go: threading.Event) -> bool:
    """On a thread of its own: a sender that says one stop when it may, and the vehicle's word on it."""

    async def live() -> bool:
        loop = asyncio.get_running_loop()
        with bus.beside() as beside:
            sender = StopSender(
                beside,
                name=stop_sender_of("gateway"),
                incarnation=1,
                authority=SigningKey(bytes(32)),
                time=TimeScale(0.0, 0.0),
                wall_s=loop.time,
                timeout_s=PATIENCE_S,
                ahead_s=lambda _: 0.0,
                sent=lambda _: None,
                ended=lambda _stop, _answer: None,
            )
            begun.set_result(loop)
            await asyncio.to_thread(go.wait, PATIENCE_S)
            answer = await sender.stop("ATV1", ADMIN, "127.0.0.1")
            sender.leave()
            return answer.done

    return asyncio.run(live())


def test_a_desk_on_a_thread_of_its_own_says_a_stop_and_hears_its_vehicle(row_of: list[Identity]) -> None:
    begun: Future[asyncio.AbstractEventLoop] = Future()
    go, done = threading.Event(), Future[bool]()

    def run(bus: ZenohBus) -> None:
        done.set_result(desk_on(bus, begun, go))

    async def main() -> None:
        row = Row(2, identities=row_of)
        thread = threading.Thread(target=run, args=(row.buses[1],), daemon=True)
        try:
            obeying(row.buses[0])
            thread.start()
            await asyncio.wrap_future(begun)
            await row.settle()
            go.set()
            assert await asyncio.wrap_future(done)
        finally:
            go.set()
            await asyncio.to_thread(thread.join, PATIENCE_S)
            row.close()

    asyncio.run(main())
