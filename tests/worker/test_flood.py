"""A worker to which more is said than its agent can take."""

from __future__ import annotations

import asyncio

import pytest
from agent_stage import Cell, FullStage, Scripted, flooded, say
from heartbeats import atv_heartbeat
from msgspec.structs import replace

from dray.body import CycleDone
from dray.protocol.runtime.events import Received, Reported
from dray.worker import inbox as inbox_module
from dray_sim.clock.loop import run

HEARTBEAT = atv_heartbeat("A1")


@pytest.fixture
def small_inbox(monkeypatch: pytest.MonkeyPatch) -> None:
    """Room for 8, and for 6 of one sender; crowded from 2 on."""
    monkeypatch.setattr(inbox_module, "INBOX", 8)
    monkeypatch.setattr(inbox_module, "CROWDED", 2)
    monkeypatch.setattr(inbox_module, "SENDER_ROOM", 6)


@pytest.mark.usefixtures("small_inbox")
def test_in_a_crowded_inbox_only_the_newest_heartbeat_of_a_sender_waits() -> None:
    beats = [replace(HEARTBEAT, seq=seq) for seq in (1, 2, 3, 5, 4)]
    worker, agent = flooded(*beats, say(1), say(2))
    heard = [event.message for _, event in agent.events if isinstance(event, Received)]
    assert heard == [beats[0], beats[1], beats[3], say(1), say(2)]
    assert (worker.inbox.dropped_heartbeats, worker.inbox.dropped_messages) == (2, 0)


@pytest.mark.usefixtures("small_inbox")
def test_one_sender_fills_no_inbox_and_pushes_out_nothing_of_others() -> None:
    flood = [("LIAR", say(number)) for number in range(100)]
    worker, agent = flooded(("A", say("first")), *flood, ("B", say("last")), ("C", HEARTBEAT))
    assert agent.heard() == ["first", *(str(number) for number in range(6)), "last"]
    assert worker.inbox.dropped_messages == 94


@pytest.mark.usefixtures("small_inbox")
def test_a_full_inbox_drops_the_oldest_message_of_whoever_has_most_there() -> None:
    worker, agent = flooded(
        ("A", say("a")), *[("S", say(number)) for number in range(7)], ("B", say("b1")), ("B", say("b2"))
    )
    assert agent.heard() == ["a", *(str(number) for number in range(1, 6)), "b1", "b2"]
    assert (worker.inbox.dropped_heartbeats, worker.inbox.dropped_messages) == (0, 2)


@pytest.mark.usefixtures("small_inbox")
def test_a_full_inbox_never_drops_what_the_body_reports() -> None:
    agent, cell = Scripted("A1"), Cell()

    async def main() -> None:
        stage = FullStage()
        worker = stage.start(agent, cell)
        await asyncio.sleep(0.01)
        for number in range(12):
            cell.report(CycleDone(str(number), number))
        await stage.flood(worker, say("no room"))
        assert worker.inbox.dropped_messages == 1

    run(main())
    assert [event for _, event in agent.events[1:]] == [
        Reported(CycleDone(str(number), number)) for number in range(12)
    ]
