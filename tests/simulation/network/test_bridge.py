"""The bridge: the factory's own thread, and what it does not take up."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from random import Random

import pytest

from dray.adapters import crossing
from dray.errors import UnavailableError
from dray.messages import Message, OrderTaken
from dray_sim.clock.loop import VirtualLoop, clock, paced
from dray_sim.network.bridge import BridgedBus, SimThread
from dray_sim.network.sim_network import SimNetwork

FAST = paced(1e6)


# --- the thread ------------------------------------------------------------------------------------


async def live_for_ever(ready: Callable[[float], None]) -> None:
    ready(clock().now_s())
    await asyncio.Event().wait()


def test_the_start_waits_until_the_factory_is_ready_and_brings_what_it_hands_out() -> None:
    thread: SimThread[float] = SimThread(live_for_ever, FAST, start_s=17.0)
    assert thread.start(timeout_s=10.0) >= 17.0
    thread.stop()


def test_an_error_before_it_is_ready_is_raised_at_the_start() -> None:
    async def fail(_: Callable[[None], None]) -> None:
        raise ValueError("no plant")

    thread = SimThread(fail, FAST)
    with pytest.raises(ValueError, match="no plant"):
        thread.start(timeout_s=10.0)
    with pytest.raises(ValueError, match="no plant"):
        thread.stop()


def test_a_factory_that_ends_before_it_is_ready_says_so() -> None:
    async def end(_: Callable[[None], None]) -> None:
        return

    thread = SimThread(end, FAST)
    with pytest.raises(UnavailableError, match="ended before it was ready"):
        thread.start(timeout_s=10.0)
    thread.stop()


@pytest.mark.parametrize("where", ["in a task", "in a callback of the clock"])
def test_an_error_of_the_running_factory_reaches_whoever_waits(where: str) -> None:
    async def fail_later(ready: Callable[[None], None]) -> None:
        ready(None)
        if where == "in a task":
            await asyncio.sleep(1.0)
            raise ZeroDivisionError
        clock().call_at(1.0, lambda: 1 / 0)
        await asyncio.Event().wait()

    async def main() -> None:
        thread = SimThread(fail_later, FAST)
        thread.start(timeout_s=10.0)
        with pytest.raises(ZeroDivisionError):
            await thread.wait()
        with pytest.raises(ZeroDivisionError):
            thread.stop()

    asyncio.run(main())


def test_stopping_lets_the_factory_clean_up_and_is_no_error() -> None:
    cleaned_up: list[str] = []

    async def live(ready: Callable[[None], None]) -> None:
        try:
            ready(None)
            await asyncio.Event().wait()
        finally:
            cleaned_up.append("yes")

    async def main() -> None:
        thread = SimThread(live, FAST)
        thread.start(timeout_s=10.0)
        thread.stop()
        thread.stop()
        await thread.wait()

    asyncio.run(main())
    assert cleaned_up == ["yes"]


def test_a_factory_that_was_never_started_may_be_stopped() -> None:
    SimThread(live_for_ever, FAST).stop()


def test_giving_up_waiting_does_not_touch_the_factory() -> None:
    async def main() -> None:
        thread: SimThread[float] = SimThread(live_for_ever, FAST)
        thread.start(timeout_s=10.0)
        waiting = asyncio.create_task(thread.wait())
        await asyncio.sleep(0)
        waiting.cancel()
        with pytest.raises(asyncio.CancelledError):
            await waiting
        assert not thread.ended.done()
        thread.stop()

    asyncio.run(main())


def test_a_factory_that_does_not_stop_is_named() -> None:
    let_go = threading.Event()

    async def block(ready: Callable[[None], None]) -> None:
        ready(None)
        let_go.wait(60.0)

    thread = SimThread(block, FAST)
    thread.start(timeout_s=10.0)
    with pytest.raises(UnavailableError, match="has not stopped"):
        thread.stop(timeout_s=0.01)
    let_go.set()
    thread.stop()


# --- the bus that is used from outside ----------------------------------------------------------------


def test_a_factory_that_takes_up_nothing_refuses_to_be_joined_and_whoever_is_there_stays(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(crossing, "QUEUE", 0)
    monkeypatch.setattr(crossing, "ORDER_ROOM", 1)
    inside, heard = VirtualLoop(), list[Message]()

    async def main() -> None:
        network = SimNetwork(inside.clock, Random(1))
        bus = BridgedBus(network, inside, asyncio.get_running_loop())
        bus.join("G", lambda _, message: heard.append(message))
        with pytest.raises(UnavailableError, match="makes none"):
            bus.join("G", lambda *_: None)
        monkeypatch.undo()
        said, crossed = OrderTaken(order="1"), asyncio.Event()

        async def live_inside() -> None:
            await asyncio.sleep(0)
            network.join("S", lambda *_: None).send("G", said)
            await asyncio.sleep(1.0)

        thread = threading.Thread(target=inside.run_until_complete, args=(live_inside(),))
        thread.start()
        thread.join()
        bus.outbound.order(crossed.set)
        await crossed.wait()
        assert heard == [said]

    asyncio.run(main())
    inside.close()
