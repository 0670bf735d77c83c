"""The replacement of one process in a running fleet: shutdown, start, and observation of the new one."""

from __future__ import annotations

import asyncio
import http.client
import time
from dataclasses import dataclass
from pathlib import Path
from urllib.request import ProxyHandler, build_opener

from dray.cli.fleet import control
from dray.cli.fleet.folder import GATEWAY, LOGS
from dray.cli.fleet.process_registry import Member, read_registry
from dray.cli.fleet.process_supervisor import Replaced
from dray.cli.fleet.rollout.canary_verdict import CANARIES, HEARD, Canary
from dray.cli.fleet.rollout.listener import Listener
from dray.cli.fleet.rollout.report import Step, Verdict
from dray.cli.fleet.software import Software
from dray.cli.runtime.listener import url_of
from dray.gateway.live.timescale import TimeScale
from dray.settings import Settings

JOIN_S = 60.0
"""Real seconds for a new process to join the bus: on a busy computer a start takes ten."""

HOLD_S = 3.0
"""Minimum real seconds of presence of a new process: a broken one ends in its first moments."""

LOOK_S = 0.1
"""Real seconds between two checks."""

LATE_S = 60.0
"""Tolerated delay of a vehicle by its plant: a dock held for another one, or a detour. In the simulated plant, without people
in the way, no vehicle is late by a second."""

BUSY_S = 5.0
"""Tolerated delay by its computer in real seconds, which matters where the plant's clock runs faster."""

READY_S = 2.0
"""Timeout of one answer of a gateway (real seconds)."""


@dataclass(frozen=True, slots=True)
class Terms:
    """The terms of a replacement.

    Attributes:
        software: the new software.
        canary_tasks: tasks to do well; 0 for none.
        patience_s: maximum time for these tasks (plant clock).
        at_once: whether to end the old one without a graceful shutdown.
    """

    software: Software
    canary_tasks: int = 0
    patience_s: float = 0.0
    at_once: bool = False


class Scene:
    """A fleet with replacements in progress.

    Args:
        folder: the fleet's folder.
        settings: the fleet's settings.
        listener: a listener on its bus.
    """

    def __init__(self, folder: Path, settings: Settings, listener: Listener) -> None:
        self._folder, self._listener = folder, listener
        self._time = TimeScale(settings.plant_epoch_s, settings.plant_epoch_s, settings.plant_speed)
        self._ready_url = f"{url_of(settings.host, settings.port)}/readyz"

    @property
    def speed(self) -> float:
        """Plant seconds per real second."""
        return self._time.speed

    @property
    def first_s(self) -> float:
        """The start of the fleet (plant clock)."""
        return self._time.plant_epoch_s

    @property
    def late_s(self) -> float:
        """The tolerated delay of a vehicle against its promise (plant clock)."""
        return LATE_S + BUSY_S * self.speed

    def now_s(self) -> float:
        """The plant's clock."""
        return self._time.to_plant_s(time.time())

    async def replace(self, member: Member, terms: Terms) -> Step:
        """Replace one process, and wait for the verdict.

        Raises:
            UnavailableError: the fleet's supervisor does not answer.
        """
        began_s = self.now_s()
        wanted = control.Replace(member.name, terms.software, terms.canary_tasks, terms.at_once)
        done = await control.replace(self._folder, wanted)
        gone_s = joined_s = time.monotonic()
        # Earlier messages were the old one's: the new one has only begun to start.
        canary = self._canary(member, terms)
        if isinstance(done, control.Refused):
            canary.fail(done.reason)
            done = Replaced(left_s=0.0, killed=False, starts=member.starts)
        else:
            with self._listener.telling(canary.on_message):
                await self._until_joined(member, done.starts, canary)
                joined_s = time.monotonic()
                await self._until_judged(member, done.starts, canary, terms.patience_s)
        return Step(
            agent=member.name,
            kind=member.kind,
            version=terms.software.version,
            verdict=_verdict(canary),
            began_s=began_s,
            ended_s=self.now_s(),
            left_s=done.left_s,
            killed=done.killed,
            away_s=joined_s - gone_s,
            canary_s=time.monotonic() - joined_s,
            tasks=canary.done,
            why=canary.failure,
        )

    async def settle(self, member: Member) -> None:
        """It has passed as a canary: its later lives are no canaries.

        Raises:
            UnavailableError: the fleet's supervisor does not answer.
        """
        await control.settle(self._folder, member.name)

    def _canary(self, member: Member, terms: Terms) -> Canary:
        canaries = CANARIES.get(member.kind) if terms.canary_tasks else None
        before = self._listener.lives.get(member.name, 0)
        if canaries is None:
            return Canary(member.name, terms.software.version, 0, before, self.late_s)
        return canaries(member.name, terms.software.version, terms.canary_tasks, before, self.late_s)

    async def _until_joined(self, member: Member, starts: int, canary: Canary) -> None:
        latest_s = time.monotonic() + JOIN_S
        while not (canary.joined or canary.failure):
            await asyncio.sleep(LOOK_S)
            self._look_after(member, starts, canary)
            if member.kind not in HEARD and await self._is_ready(member):
                canary.note_present()
            elif time.monotonic() > latest_s:
                canary.fail(f"it was not on the bus within {JOIN_S:.0f} s; see {self._log(member)}")

    async def _until_judged(self, member: Member, starts: int, canary: Canary, patience_s: float) -> None:
        held_s, latest_s = time.monotonic() + HOLD_S, self.now_s() + patience_s
        while not canary.failure and (time.monotonic() < held_s or not canary.passed):
            if not canary.passed and self.now_s() > latest_s and time.monotonic() > held_s:
                return
            await asyncio.sleep(LOOK_S)
            canary.look(self.now_s())
            self._look_after(member, starts, canary)

    def _look_after(self, member: Member, starts: int, canary: Canary) -> None:
        now = read_registry(self._folder).member(member.name)
        if now.starts != starts or not now.runs:
            canary.fail(f"its process has ended; see {self._log(member)}")

    async def _is_ready(self, member: Member) -> bool:
        if member.name not in await self._listener.present():
            return False
        return member.kind != GATEWAY or await asyncio.to_thread(_answers, self._ready_url)

    def _log(self, member: Member) -> Path:
        return self._folder / LOGS / f"{member.name}.log"


def _verdict(canary: Canary) -> Verdict:
    if canary.failure:
        return Verdict.FAILED
    return Verdict.PASSED if canary.passed else Verdict.UNTRIED


def _answers(url: str) -> bool:
    """Whether a gateway accepts orders."""
    try:
        # No proxy: the gateway is on this computer.
        with build_opener(ProxyHandler({})).open(url, timeout=READY_S):
            return True
    except (OSError, http.client.HTTPException):
        return False
