"""The bounded queue from other threads into a loop."""

from __future__ import annotations

import asyncio
import logging
import threading
from collections.abc import Callable
from typing import Any

import pytest
from heartbeats import atv_heartbeat
from msgspec.structs import replace

from dray.adapters import crossing as crossing_module
from dray.adapters.crossing import Crossing
from dray.errors import UnavailableError
from dray.messages import AtvHeartbeat, Message, OrderTaken

SAY = OrderTaken(order="1")
HEARTBEAT = atv_heartbeat("A1")


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
    monkeypatch.setattr(crossing_module, "CALLS_PER_TURN", 10)
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


def test_a_call_that_fails_holds_up_no_other_is_counted_and_told(
    other_side: OtherSide, caplog: pytest.LogCaptureFixture
) -> None:
    crossing = Crossing(other_side)
    seen: list[Any] = []

    def fail() -> None:
        raise ZeroDivisionError

    crossing.order(fail)
    crossing.order(seen.append, 1)
    with caplog.at_level(logging.ERROR, "dray.supervision"):
        other_side.take_turn()
    assert seen == [1]
    assert crossing.failures.total == 1
    assert "ZeroDivisionError" in caplog.text


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """A queue of ten, half of it for heartbeats, and room for three orders more."""
    monkeypatch.setattr(crossing_module, "QUEUE", 10)
    monkeypatch.setattr(crossing_module, "HEARTBEAT_ROOM", 5)
    monkeypatch.setattr(crossing_module, "ORDER_ROOM", 3)


class Listener:
    """An agent on the other side."""

    def __init__(self) -> None:
        self.heard: list[tuple[str, Message]] = []

    def on_message(self, sender: str, message: Message) -> None:
        self.heard.append((sender, message))


def beat(seq: int) -> AtvHeartbeat:
    return replace(HEARTBEAT, seq=seq)


@pytest.mark.usefixtures("small")
def test_of_the_heartbeats_that_crowd_the_queue_the_newest_is_kept(other_side: OtherSide) -> None:
    crossing, listener, other_ear = Crossing(other_side), Listener(), Listener()
    for seq in range(9):
        crossing.say(beat(seq), listener.on_message, "A1", beat(seq))
    crossing.say(SAY, listener.on_message, "A1", SAY)
    for to, sender in ((listener, "A2"), (other_ear, "A1")):
        crossing.say(beat(9), to.on_message, sender, beat(9))
    crossing.say(beat(10), listener.on_message, "A1", beat(10))
    other_side.take_turn()
    first = [("A1", beat(seq)) for seq in range(5)]
    assert listener.heard == [*first, ("A1", beat(10)), ("A1", SAY), ("A2", beat(9))]
    assert other_ear.heard == [("A1", beat(9))]
    assert (crossing.dropped_heartbeats, crossing.dropped_messages) == (4, 0)


@pytest.mark.usefixtures("small")
def test_a_heartbeat_takes_no_place_of_one_that_has_crossed(other_side: OtherSide) -> None:
    crossing, listener = Crossing(other_side), Listener()
    for seq in range(7):
        crossing.say(beat(seq), listener.on_message, "A1", beat(seq))
    other_side.take_turn()
    for seq in range(7, 14):
        crossing.say(beat(seq), listener.on_message, "A1", beat(seq))
    other_side.take_turn()
    assert [message.seq for _, message in listener.heard] == [0, 1, 2, 3, 4, 6, 7, 8, 9, 10, 11, 13]
    assert crossing.dropped_heartbeats == 2


@pytest.mark.usefixtures("small")
def test_a_full_queue_drops_and_counts_all_messages_but_no_subscription(other_side: OtherSide) -> None:
    crossing, listener = Crossing(other_side), Listener()
    for number in range(13):
        message = OrderTaken(order=str(number))
        crossing.say(message, listener.on_message, "S", message)
    crossing.say(HEARTBEAT, listener.on_message, "A1", HEARTBEAT)
    seen: list[str] = []
    crossing.order(seen.append, "subscription")
    other_side.take_turn()
    assert [message.order for _, message in listener.heard] == [str(number) for number in range(10)]
    assert seen == ["subscription"]
    assert (crossing.dropped_heartbeats, crossing.dropped_messages) == (1, 3)


@pytest.mark.usefixtures("small")
def test_an_order_too_many_is_refused_at_its_source_and_all_others_arrive(other_side: OtherSide) -> None:
    crossing = Crossing(other_side)
    seen: list[int] = []
    for number in range(13):
        crossing.order(seen.append, number)
    with pytest.raises(UnavailableError, match="has 13 calls before it and makes none"):
        crossing.order(seen.append, 13)
    other_side.take_turn()
    assert seen == list(range(13))
    crossing.order(seen.append, 14)
    other_side.take_turn()
    assert seen[-1] == 14


@pytest.mark.usefixtures("small")
def test_an_offer_takes_no_room_of_orders_and_is_told_so(other_side: OtherSide) -> None:
    crossing = Crossing(other_side)
    seen: list[int] = []
    assert [crossing.offer(seen.append, number) for number in range(12)] == [True] * 10 + [False] * 2
    crossing.order(seen.append, 12)
    other_side.take_turn()
    assert seen == [*range(10), 12]
    assert crossing.dropped_messages == 2


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


def test_one_sender_pushes_out_nobody_and_its_newest_heartbeat_wins_whatever_comes_with_it(
    other_side: OtherSide, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(crossing_module, "QUEUE", 16)
    monkeypatch.setattr(crossing_module, "HEARTBEAT_ROOM", 4)
    monkeypatch.setattr(crossing_module, "SENDER_ROOM", 3)
    crossing = Crossing(other_side)
    seen: list[tuple[str, Message]] = []

    def arrive(sender: str, message: Message, _context: str) -> None:
        seen.append((sender, message))

    for _ in range(100):
        crossing.say(SAY, arrive, "LIAR", SAY, "")
    for seq in range(10):
        beat = replace(HEARTBEAT, seq=seq)
        crossing.say(beat, arrive, "A1", beat, f"trace {seq}")
    crossing.say(SAY, arrive, "A2", SAY, "")
    other_side.take_turn()
    assert seen == [*[("LIAR", SAY)] * 7, ("A1", replace(HEARTBEAT, seq=9)), ("A2", SAY)]
    assert (crossing.dropped_messages, crossing.dropped_heartbeats) == (93, 9)
