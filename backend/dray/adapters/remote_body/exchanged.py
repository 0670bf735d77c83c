"""A body elsewhere, from its agent's side, over any channel: parts arrive once and in order, and silence is noticed."""

from __future__ import annotations

import asyncio
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable

from dray.adapters.remote_body.exchange import Exchange, Part
from dray.body import BodyState, Instruction, Report, bounded
from dray.ports import nobody_hears

LOOK_EVERY_S = 1.0
SILENT_LOOKS = 10
"""Consecutive checks without a message before the body is asked whether it is there; it sends ten between two checks. A cut
link is bypassed sooner."""


class ExchangedBody(ABC):
    """Implements `dray.ports.Body` for a body elsewhere. A subclass writes the letters, and passes on their content."""

    def __init__(self) -> None:
        self._exchange = Exchange()
        self._report: Callable[[Report], None] = nobody_hears
        self._state: BodyState
        self._silent = False
        self._given_up = False
        """The maximum of instructions is unconfirmed; the body gets no more."""

    def instruct(self, instruction: Instruction) -> None:
        """See `dray.ports.Body`. Once an instruction could not be kept, all later ones are dropped: the body is lost."""
        self._given_up |= self._exchange.full
        if not self._given_up:
            self._exchange.say(self._part(instruction))
            self._write()

    def sense(self) -> BodyState:
        """See `dray.ports.Body`: the last received state."""
        return self._state

    def attach(self, report: Callable[[Report], None]) -> None:
        """See `dray.ports.Body`."""
        self._report = report

    @abstractmethod
    def _part(self, instruction: Instruction) -> Part:
        """Encode an instruction for a letter."""

    @abstractmethod
    def _write(self) -> None:
        """Send the next letter."""

    def _told(self, state: BodyState, reports: Iterable[Report]) -> None:
        """Take a letter's content: the body's state and the new reports."""
        self._silent, self._state = False, bounded(state)
        for report in reports:
            self._report(bounded(report))
        if self._exchange.due:
            self._write()

    async def _silence(self) -> None:
        """Wait until the body has been silent for a while, in checks and not in seconds: our own process may have been delayed."""
        looks = 0
        while looks < SILENT_LOOKS and not self._given_up:
            self._silent = True
            await asyncio.sleep(LOOK_EVERY_S)
            looks = looks + 1 if self._silent else 0
