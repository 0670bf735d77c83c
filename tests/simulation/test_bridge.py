"""The bridge: bounded queues between two loops, and the factory's own thread."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from typing import Any

import pytest

from dray.errors import UnavailableError
from dray.messages import AtvHeartbeat, AtvStatus, OrderTaken, Pose
from dray_sim import bridge as bridge_module
from dray_sim.bridge import Crossing, SimThread
from dray_sim.loop import clock, paced

FAST = paced(1e6)
SAY = OrderTaken(order="1")
HEARTBEAT = AtvHeartbeat(
    atv="A1",
    incarnation=1,
    seq=1,
    at_s=0.0,
    status=AtvStatus.IDLE,
    pose=Pose(0.0, 0.0, 0.0),
    node="n1",
    speed_mps=0.0,
    battery_frac=1.0,
)


class OtherSide(asyncio.SelectorEventLoop):
    """A loop that only notes how often it was woken, and takes its turn when the test says so."""

    def __init__(self) -> None:
        super().__init__()
        self.woken: list[Callable[[], object]] = []

    def call_soon_threadsafe(self, callback: Any, *_: Any, **__: Any) -> Any:  # type: ignore[override]
        self._check_closed()  # type: ignore[attr-defined]
        self.woken.append(callback)

    def take_turn(self) -> None:
        self.woken.pop(0)()


@pytest.fixture
def other_side() -> Any:
    loop = OtherSide()
    yield loop
    loop.close()


# --- the queue -------------------------------------------------------------------------------------


def test_a_burst_costs_one_wake_up_and_keeps_its_order(other_side: OtherSide) -> None:
    crossing = Crossing(other_side)
    seen: list[Any] = []
    for number in range(100):
        crossing.order(seen.append, number)
    assert len(other_side.woken) == 1
    other_side.take_turn()
    assert seen == list(range(100))
    crossing.order(seen.append, 100)
    assert len(other_side.woken) == 1


def test_a_long_queue_is_worked_off_in_turns(other_side: OtherSide, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bridge_module, "CALLS_PER_TURN", 10)
    crossing = Crossing(other_side)
    seen: list[Any] = []
    for number in range(25):
        crossing.order(seen.append, number)
    turns = 0
    while other_side.woken:
        other_side.take_turn()
        turns += 1
    assert turns == 3
    assert seen == list(range(25))


def test_a_call_that_fails_holds_up_no_other(other_side: OtherSide) -> None:
    crossing = Crossing(other_side)
    seen: list[Any] = []

    def fail() -> None:
        raise ZeroDivisionError

    crossing.order(fail)
    crossing.order(seen.append, 1)
    with pytest.raises(ZeroDivisionError):
        other_side.take_turn()
    other_side.take_turn()
    assert seen == [1]


def test_heartbeats_are_dropped_first_and_subscriptions_never(
    other_side: OtherSide, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bridge_module, "QUEUE", 10)
    monkeypatch.setattr(bridge_module, "HEARTBEAT_ROOM", 5)
    crossing = Crossing(other_side)
    seen: list[Any] = []
    for _ in range(8):
        crossing.say(HEARTBEAT, seen.append, "heartbeat")
    for _ in range(8):
        crossing.say(SAY, seen.append, "message")
    crossing.order(seen.append, "subscription")
    other_side.take_turn()
    assert seen == ["heartbeat"] * 5 + ["message"] * 5 + ["subscription"]
    assert (crossing.dropped_heartbeats, crossing.dropped_messages) == (3, 3)


def test_nothing_piles_up_for_a_side_that_has_closed(other_side: OtherSide) -> None:
    crossing = Crossing(other_side)
    other_side.close()
    for _ in range(10):
        crossing.order(print, "never")
        assert not crossing._calls


def test_no_call_is_left_behind_however_the_threads_interleave() -> None:
    calls, threads = 5_000, 4

    async def main() -> int:
        crossing = Crossing(asyncio.get_running_loop())
        seen: list[int] = []
        done = asyncio.Event()

        def note(number: int) -> None:
            seen.append(number)
            if len(seen) == calls * threads:
                done.set()

        def shout() -> None:
            for number in range(calls):
                crossing.order(note, number)

        speakers = [threading.Thread(target=shout) for _ in range(threads)]
        for speaker in speakers:
            speaker.start()
        async with asyncio.timeout(60.0):
            await done.wait()
        for speaker in speakers:
            speaker.join()
        return len(seen)

    assert asyncio.run(main()) == calls * threads


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
