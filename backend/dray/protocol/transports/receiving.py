"""How a coordinator judges a carrier's report that its load is down: the destination's count decides.

    counted     that much is there, and the transport has ended
    waits       the count may come later than the carrier's report
    short       the count differs by COUNT_S: the difference is disputed, and missing pieces are missing.
                After two handovers without a counted piece a person is asked to look (`held`)

The coordinator's own body counts material, by its carrier's name (`StockChanged`). The machine's body counts
finished goods as they leave, and the gate of the delivery warehouses as they arrive; the strategist reports whose
pieces have come (`Confirmed`). While the strategist is silent, the carrier is released on its report, and the
pieces are compared with the gate's count later. The same holds where people count at the gate: pieces that they
have not reported yet are not missing.

The carrier's report is accepted without a count under a contract of the coordinator's earlier life. The same holds
for pieces that no goal wants any more.
"""

from __future__ import annotations

from enum import Enum
from typing import Protocol, cast

from dray.messages import Transport
from dray.protocol.contract_net.task import OpenTask

COUNT_S = 8.0
"""Maximum delay of a count after the carrier's report (s): both are repeated until they are heard. Well below the half
minute after which a carrier gives its machine up."""


class GateCount(Protocol):
    """The delivery warehouse gate's count of one goal, as its machine has heard it."""

    disputes: int
    """Successive handovers of its pieces without a counted piece."""

    by_people: bool
    """Whether people count, later than goods come."""

    @property
    def heard_s(self) -> float:
        """When the strategist last reported it (plant clock)."""

    def arrived_by(self, vehicle: str) -> int:
        """Pieces that a vehicle has brought and that have ended no other transport."""


class Verdict(Enum):
    """The verdict on a carrier's report."""

    COUNTED = "counted"
    WAITS = "waits"
    SHORT = "short"


def verdict_on(task: OpenTask, goal: GateCount | None, place: str, now_s: float) -> tuple[Verdict, int]:
    """How much of a reported load was counted.

    Args:
        task: the transport; its carrier has reported the load as down (`Receipt.said_s`).
        goal: the goods' goal; None for material, and for pieces that no goal wants.
        place: its coordinator.
        now_s: the present time.

    Returns:
        The verdict, and the pieces that are there.
    """
    work = cast(Transport, task.work)
    is_patient = now_s - task.contract.receipt.said_s < COUNT_S
    if work.destination == place:
        if not task.witnessed:
            return Verdict.COUNTED, max(work.quantity, task.contract.receipt.counted)
        return _judged(task.contract.receipt.counted, work.quantity, is_patient)
    if task.witnessed and not task.is_loaded:
        return _judged(0, work.quantity, is_patient)
    if goal is None or goal.by_people:
        return Verdict.COUNTED, work.quantity
    arrived = goal.arrived_by(task.primary)
    if arrived < work.quantity and not is_patient and goal.heard_s < task.contract.receipt.said_s:
        return (
            Verdict.COUNTED,
            work.quantity,
        )  # The strategist is away, and the gate still lets goods in.
    return _judged(min(arrived, work.quantity), work.quantity, is_patient)


def _judged(counted: int, quantity: int, is_patient: bool) -> tuple[Verdict, int]:
    if counted >= quantity:
        return Verdict.COUNTED, counted
    return (Verdict.WAITS if is_patient else Verdict.SHORT), counted
