"""M8, which waits for somebody who counts: nobody can tell whether ATV5 has taken a load of housings."""

from __future__ import annotations

from typing import Any

from obedient_machine import STATION, ObedientMachine

from dray.messages import BufferLevel, DoubtfulLoad

DOUBT = DoubtfulLoad(f"{STATION}.2-load-1", "ATV5", "housing", 24)

IN_STOCK = BufferLevel(item="housing", level=12, capacity=72)


class MachineInDoubt(ObedientMachine):
    """M8; see `ObedientMachine`."""

    def state(self) -> dict[str, Any]:
        """Whatever was counted, nobody is asked any more."""
        return {"buffers": (IN_STOCK,), "goods": (), "doubts": () if self.heard else (DOUBT,)}
