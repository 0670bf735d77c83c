"""How a process ends: asked in order first, and made to when that is not enough."""

from __future__ import annotations

import asyncio
import signal

import pytest

from dray.cli.serving import asked_by_signals

LONG_S = 600.0
"""Nothing in a test takes so long."""


def ends(*signals: signal.Signals, within_s: float = LONG_S) -> list[str]:
    """What an agent is told, one signal after the other; without any time to leave, until it is stopped."""
    told: list[str] = []

    async def main() -> None:
        heard: asyncio.Queue[str] = asyncio.Queue()

        def leave() -> None:
            heard.put_nowait("leave")

        def stop() -> None:
            heard.put_nowait("stop")

        with asked_by_signals(leave, stop, within_s):
            for each in signals:
                signal.raise_signal(each)
                told.append(await heard.get())
            if not within_s:
                told.append(await heard.get())

    asyncio.run(main())
    return told


def test_a_sigterm_asks_it_to_leave_and_a_second_one_stops_it() -> None:
    assert ends(signal.SIGTERM) == ["leave"]
    assert ends(signal.SIGTERM, signal.SIGTERM) == ["leave", "stop"]


def test_ctrl_c_stops_it_at_once_also_while_it_leaves() -> None:
    assert ends(signal.SIGINT) == ["stop"]
    assert ends(signal.SIGTERM, signal.SIGINT) == ["leave", "stop"]


def test_when_its_time_is_over_it_is_stopped() -> None:
    assert ends(signal.SIGTERM, within_s=0.0) == ["leave", "stop"]


@pytest.mark.parametrize("signals", [(), (signal.SIGTERM,), (signal.SIGINT,)])
def test_afterwards_signals_are_what_they_were(signals: tuple[signal.Signals, ...]) -> None:
    before = [signal.getsignal(each) for each in (signal.SIGINT, signal.SIGTERM)]
    ends(*signals)
    assert [signal.getsignal(each) for each in (signal.SIGINT, signal.SIGTERM)] == before
