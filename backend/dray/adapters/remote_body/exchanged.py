"""A body elsewhere as its agent has it, whatever the way there: what is said is heard once and in order, and silence is noticed."""

from __future__ import annotations

import asyncio
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable

from dray.adapters.remote_body.exchange import Exchange, Part
from dray.body import BodyState, Instruction, Report, bounded

LOOK_EVERY_S = 1.0
SILENT_LOOKS = 10
"""A body is asked whether it is there when so many looks one after the other find that it has told nothing, which
it does ten times between two of them. A cut link is gone round sooner."""


class ExchangedBody(ABC):
    """Implements `dray.ports.Body` for a body that is elsewhere. Whoever derives from it writes letters, and tells what came in one."""

    def __init__(self) -> None:
        self._exchange = Exchange()
        self._report: Callable[[Report], None] = _nobody_hears
        self._state: BodyState
        self._silent = False
        self._given_up = False
        """The other side lacks as many instructions as are kept; it is told no more."""

    def instruct(self, instruction: Instruction) -> None:
        """See `dray.ports.Body`. After an instruction that could not be kept, all are in vain: the body is lost."""
        self._given_up |= self._exchange.full
        if not self._given_up:
            self._exchange.say(self._part(instruction))
            self._write()

    def sense(self) -> BodyState:
        """See `dray.ports.Body`: how it was when its side told it last."""
        return self._state

    def attach(self, report: Callable[[Report], None]) -> None:
        """See `dray.ports.Body`."""
        self._report = report

    @abstractmethod
    def _part(self, instruction: Instruction) -> Part:
        """An instruction as it goes into a letter."""

    @abstractmethod
    def _write(self) -> None:
        """Send what the other side is to get now."""

    def _told(self, state: BodyState, reports: Iterable[Report]) -> None:
        """A letter has come: how the body is, and what is new."""
        self._silent, self._state = False, bounded(state)
        for report in reports:
            self._report(bounded(report))
        if self._exchange.due:
            self._write()

    async def _silence(self) -> None:
        """Wait until it has told nothing for a while, in looks and not in seconds: we may be held up ourselves."""
        looks = 0
        while looks < SILENT_LOOKS and not self._given_up:
            self._silent = True
            await asyncio.sleep(LOOK_EVERY_S)
            looks = looks + 1 if self._silent else 0


def _nobody_hears(report: Report) -> None:
    """What a body reports before its agent listens; its state tells it all the same."""
