"""M8, which waits for somebody who looks for housings that were said to be there twice, or at a dock."""

from __future__ import annotations

from typing import Any

from gateway_kit import House
from msgspec.structs import replace
from obedient_machine import STATION, ObedientMachine

from dray.messages import Reason, Role, TaskBrief, Transport
from dray.messages.fact import TaskOpened

TASK = "M8-9"

WORK = Transport(item="housing", quantity=24, sources=("S3",), destination=STATION, ability="tote")


class MachineThatWaits(ObedientMachine):
    """M8; see `ObedientMachine`. With `fails_at` vehicles could not load or unload the housings there."""

    def __init__(self, house: House, at_s: float, fails_at: str = "") -> None:
        self._brief = TaskBrief(
            task=TASK,
            epoch=3,
            item=WORK.item,
            quantity=WORK.quantity,
            source="",
            destination=WORK.destination,
            deadline_s=at_s + 300.0,
            trouble=Reason.DISPUTED,
            fails_at=fails_at,
        )
        super().__init__(house, at_s, TaskOpened(TASK, 1, Role.PRIMARY, 1, WORK, 20.0, at_s + 900.0, 2.0))

    def state(self) -> dict[str, Any]:
        """Whatever was seen, nobody is asked any more."""
        brief = replace(self._brief, trouble=None, fails_at="") if self.heard else self._brief
        return {"tasks": (brief,)}
