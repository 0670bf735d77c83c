"""An agent whose controller is away: how long it waits, and what it logs meanwhile."""

from __future__ import annotations

import asyncio
import logging
from typing import Any

import pytest

from dray.adapters.signals.signal import LinkListener
from dray.cli.runtime.bodies.embodied import REMIND_EVERY_S
from dray.cli.runtime.bodies.signals import SAY_EVERY_S, SILENT_S, waited_for
from dray.supervision import Failures
from dray_sim.clock.loop import JUMP, clock, run


class Gate:
    """A body that says why its controller is away."""

    def __init__(self) -> None:
        self.away = ""
        self.away_since_s: float | None = None


class Wire:
    """A link without an end."""

    def __init__(self) -> None:
        self.linked, self.failures = asyncio.Event(), Failures("wire")
        self.linked.set()

    def write(self) -> None:
        """Nobody is there."""

    async def run(self, _listener: LinkListener) -> None:
        await asyncio.Event().wait()


@pytest.mark.parametrize("speed", [1.0, 20.0])
def test_an_agent_ends_when_its_controller_was_away_for_ten_real_seconds(speed: float) -> None:
    async def story() -> float:
        now, gate = clock(), Gate()
        gate_body: Any = gate
        async with waited_for("gate", gate_body, Wire(), now, speed) as embodied:
            gate.away, gate.away_since_s = "cut", now.now_s()
            await embodied.lost()
        return now.now_s()

    took_s = run(story(), JUMP)
    assert SILENT_S * speed <= took_s <= SILENT_S * speed + 1.0


@pytest.mark.parametrize("is_ready", [True, False])
def test_a_reason_that_changes_all_the_time_is_logged_now_and_then(
    caplog: pytest.LogCaptureFixture, *, is_ready: bool
) -> None:
    span_s = 60.0

    async def story() -> None:
        now, gate = clock(), Gate()
        gate_body: Any = gate
        gate.away_since_s = None if is_ready else now.now_s()

        async def lives() -> None:
            async with waited_for("gate", gate_body, Wire(), now, 1.0) as embodied:
                await embodied.lost()

        living = asyncio.create_task(lives())
        while now.now_s() < span_s:
            await asyncio.sleep(0.07)
            gate.away = f"it is {now.now_s():.2f} o'clock"
            gate.away_since_s = now.now_s()
        living.cancel()
        await asyncio.gather(living, return_exceptions=True)

    with caplog.at_level(logging.WARNING, "dray"):
        run(story(), JUMP)
    lines = [record for record in caplog.records if "waits for its controller" in record.message]
    assert span_s / REMIND_EVERY_S < len(lines) <= span_s / SAY_EVERY_S + 1
