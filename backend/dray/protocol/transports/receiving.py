"""What a coordinator makes of a carrier's word that its load is down: the dock where it was to go has the last word.

    counted     that much is there, and the transport has ended
    waits       the dock may still tell: its count may come later than the carrier's word
    short       the dock has told something else by COUNT_S: the difference is disputed, and what is missing is missing.
                Where nothing was counted twice, a person is asked to look (`held`)

Material is counted by the coordinator's own body, and taken by its carrier's name (`StockChanged`). Finished goods are counted as
they leave by the machine's own body, and as they arrive by the gate of the delivery warehouses: the strategist tells
whose pieces have come in (`Confirmed`). While the strategist says nothing at all, the carrier is let go on its word, and the
pieces are compared with the gate's count as soon as it is heard again. So it is where people count at the gate, who say it later: what they
have not said yet is not missing.

Nobody has counted, and the carrier's word is taken, where the contract was made by an earlier life of the coordinator, and
for pieces that no goal wants any more.
"""

from __future__ import annotations

from enum import Enum
from typing import Protocol, cast

from dray.messages import Transport
from dray.protocol.contract_net.task import OpenTask

COUNT_S = 8.0
"""A count may come so much later than the carrier's word: it is repeated until it is heard, as that word is. Well below
the half minute after which a carrier gives its machine up."""


class GateCount(Protocol):
    """What the gate of the delivery warehouses has counted of one goal, as its machine has heard it."""

    disputes: int
    """Handovers of its pieces, one after the other, of which nothing was counted."""

    by_people: bool
    """People count, later than goods come."""

    @property
    def heard_s(self) -> float:
        """When the strategist has told it last (plant clock)."""

    def arrived_by(self, vehicle: str) -> int:
        """Pieces that a vehicle has brought and that no other transport was ended by."""


class Verdict(Enum):
    """What the dock says of a carrier's word."""

    COUNTED = "counted"
    WAITS = "waits"
    SHORT = "short"


def verdict_on(task: OpenTask, goal: GateCount | None, place: str, now_s: float) -> tuple[Verdict, int]:
    """How much of a load that is said to be down has been counted.

    Args:
        task: the transport; its carrier has said so (`Receipt.said_s`).
        goal: whose goods these are; None for material, and for pieces that no goal wants.
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
        )  # The strategist is away, and the gate goes on letting goods in.
    return _judged(min(arrived, work.quantity), work.quantity, is_patient)


def _judged(counted: int, quantity: int, is_patient: bool) -> tuple[Verdict, int]:
    if counted >= quantity:
        return Verdict.COUNTED, counted
    return (Verdict.WAITS if is_patient else Verdict.SHORT), counted
