"""A real body at simulated places: a floor is told its picks and drops, and counts them.

A vehicle behind VDA 5050 picks and drops by itself, and no simulated place sees it. So its agent's process tells the floor each
reported transfer before the agent hears of it: a transfer that the floor has not counted by then is counted nowhere.

The floor decides. It counts for the vehicles of its start option (`DRAY_FOREIGN`), and opens no dock on request. It accepts only
drops of loads that were picked up there. Refusals are logged; the agent hears the vehicle's report all the same, and the handover
is disputed.
"""

from __future__ import annotations

import asyncio
import logging
from collections import deque
from collections.abc import Awaitable, Callable

from dray.body import ActionDone, ActionFailed, BodyState, Drop, Instruction, Pick, Report
from dray.ports import Body

Tell = Callable[[Pick | Drop], Awaitable[str]]
"""Tells the floor of a transfer; returns the reason why it is not counted, empty when it is."""

WAITING_MAX = 1_000
"""Maximum reports that wait for the floor: many more than come during an outage of the floor."""

_log = logging.getLogger(__name__)


class CountedBody:
    """Implements `dray.ports.Body` for one vehicle whose transfers are counted before they are reported.

    Args:
        vehicle: its id, for the log.
        body: the vehicle's own body.
        tell: tells the floor.
    """

    def __init__(self, vehicle: str, body: Body, tell: Tell) -> None:
        self._vehicle, self._body, self._tell = vehicle, body, tell
        self._action: Pick | Drop | None = None
        """The transfer under way: a vehicle has one at a time."""
        self._waiting: deque[tuple[Report, Pick | Drop | None]] = deque(maxlen=WAITING_MAX)
        """Reports in order, each with the transfer to tell the floor first."""
        self._came = asyncio.Event()
        self._report: Callable[[Report], None] = lambda _: None
        body.attach(self._on_report)

    def instruct(self, instruction: Instruction) -> None:
        """See `dray.ports.Body`."""
        if isinstance(instruction, Pick | Drop):
            self._action = instruction
        self._body.instruct(instruction)

    def sense(self) -> BodyState:
        """See `dray.ports.Body`: the present state; its reports may still wait for the floor."""
        return self._body.sense()

    def attach(self, report: Callable[[Report], None]) -> None:
        """See `dray.ports.Body`."""
        self._report = report

    async def run(self) -> None:
        """Tell the floor and then the agent, until cancelled.

        Raises:
            UnavailableError: the floor is gone, or does not count for this vehicle.
        """
        while True:
            await self._came.wait()
            self._came.clear()
            while self._waiting:
                report, done = self._waiting.popleft()
                if done is not None and (reason := await self._tell(done)):
                    _log.warning("%s: the floor has not counted %s: %s", self._vehicle, done, reason)
                self._report(report)

    def _on_report(self, report: Report) -> None:
        self._waiting.append((report, self._ended(report)))
        self._came.set()

    def _ended(self, report: Report) -> Pick | Drop | None:
        """The transfer that a report completes; None for none."""
        action = self._action
        if action is None or not isinstance(report, ActionDone | ActionFailed):
            return None
        if report.order != action.order:
            return None
        self._action = None
        return action if isinstance(report, ActionDone) else None
