"""One production goal of a machine, and its progress."""

from __future__ import annotations

from msgspec import UNSET

from dray.memory import GoalMemory
from dray.messages import Confirmed, GoalBrief, Production
from dray.protocol.runtime.events import NEVER_S

GOODS_LEAVE_S = 180.0
"""How long a returned goal waits for the delivery of its finished pieces (s): some transports. Then they are made again."""


class Goal:
    """One production goal of a machine. `delivered + lost_in_transit <= committed <= made` at all times.

    Args:
        goal: its id.
        work: its product and quantity.
        deadline_s: its deadline (plant clock).
        strategist: the strategist that has given it.
        epoch, number: epoch of the contract, and number of its award.
    """

    __slots__ = (
        "arrived",
        "brought",
        "by_people",
        "came_before",
        "committed",
        "confirmed",
        "credited",
        "deadline_s",
        "delivered",
        "disputes",
        "epoch",
        "given_back_s",
        "heard_s",
        "held",
        "id",
        "lost_in_transit",
        "made",
        "number",
        "promised_s",
        "stranded",
        "strategist",
        "taken_over",
        "work",
    )

    def __init__(
        self,
        goal: str,
        work: Production,
        deadline_s: float,
        strategist: str = "",
        epoch: int = 1,
        number: int = 1,
    ) -> None:
        self.id = goal
        self.work = work
        self.deadline_s = deadline_s
        self.strategist = strategist
        self.epoch = epoch
        self.number = number
        self.held = 1
        """Epoch with which `strategist` holds its order; it rises with each takeover of the order."""
        self.taken_over = False
        """Whether a strategist has said that it has taken the order over."""
        self.promised_s = 0.0
        """The promised finish that holds now (plant clock); 0 if unknown. Only `promises` moves it."""
        self.came_before = 0
        """More urgent goals that have come before it since it was taken."""
        self.given_back_s: float | None = None
        """Since when others may make its missing pieces; None while the machine works at it."""
        self.confirmed = False
        """Whether the strategist has confirmed the acceptance; no piece is begun before."""
        self.made = 0
        self.committed = 0
        """Pieces for which a transport was announced."""
        self.delivered = 0
        """Pieces that were handed over at the delivery warehouse."""
        self.lost_in_transit = 0
        """Pieces that were sent and will not arrive: they are made once more."""
        self.arrived = 0
        """Pieces counted by the gate, by the strategist's last message."""
        self.brought: dict[str, int] = {}
        """Arrived pieces by vehicle, as far as the gate has reported."""
        self.by_people = False
        """Whether people count at the gate, later than goods come: carriers are released on their report."""
        self.credited: dict[str, int] = {}
        """Pieces of handovers accepted in this life, by vehicle."""
        self.heard_s = -NEVER_S
        """When the strategist last reported arrivals."""
        self.disputes = 0
        """Successive handovers of its pieces without a counted piece."""
        self.stranded = 0
        """Pieces on board of failed vehicles, which wait for a person's decision."""

    @property
    def to_make(self) -> int:
        return self.work.quantity - self.made + self.lost_in_transit

    @property
    def is_of_parts(self) -> bool:
        """Whether its pieces are parts that stay here until they are fetched: each counts as delivered when it is made."""
        return bool(self.work.part_of)

    def note_made(self, pieces: int) -> None:
        """Pieces were made, or taken from stock."""
        self.made += pieces
        if self.is_of_parts:
            self.committed += pieces
            self.delivered += pieces

    @property
    def ready(self) -> int:
        """Finished pieces without an announced transport."""
        return self.made - self.committed

    @property
    def on_the_way(self) -> int:
        """Pieces of transports that have not ended."""
        return self.committed - self.delivered - self.lost_in_transit

    def is_offered(self, now_s: float) -> bool:
        """Whether others may make its missing pieces: finished ones have left, or that takes too long."""
        if self.given_back_s is None or self.to_make <= 0:
            return False
        if self.stranded:
            return False
        return not (self.ready or self.on_the_way) or now_s >= self.given_back_s + GOODS_LEAVE_S

    def lose(self, pieces: int) -> None:
        """Count pieces on the way that will not arrive."""
        self.lost_in_transit += pieces

    def on_count(self, confirmed: Confirmed, now_s: float) -> None:
        """Handle the strategist's report of the gate's count; counts only grow."""
        if confirmed.arrived >= self.arrived:
            self.arrived = confirmed.arrived
            self.brought = {each.vehicle: each.pieces for each in confirmed.brought}
        self.by_people = self.by_people or confirmed.by_people
        self.heard_s = now_s

    def arrived_by(self, vehicle: str) -> int:
        """Arrived pieces of a vehicle that no accepted handover has used.

        Pieces without a named vehicle may be any vehicle's.
        """
        named = self.brought.get(vehicle, 0) - self.credited.get(vehicle, 0)
        unnamed = self.arrived - sum(self.brought.values())
        covered = sum(min(pieces, self.brought.get(each, 0)) for each, pieces in self.credited.items())
        used = max(0, self.delivered - covered)
        return max(0, min(max(0, named) + max(0, unnamed - used), self.arrived - self.delivered))

    def deliver(self, vehicle: str, sent: int, counted: int) -> None:
        """A handover was accepted with `counted` of `sent` pieces."""
        self.delivered += counted
        self.lost_in_transit += sent - counted
        self.credited[vehicle] = self.credited.get(vehicle, 0) + counted

    def note_arrived(self, arrived: int) -> int:
        """Take over the gate's count if it differs from the machine's.

        While pieces are on the way the counts may differ, and nothing is changed.

        Returns:
            Ready pieces that this goal does not need any more.
        """
        if self.on_the_way or arrived == self.delivered or self.is_of_parts:
            return 0
        if self.by_people and arrived < self.delivered:
            return 0
        # All sent pieces have either arrived or will not: none is on the way.
        self.delivered = min(arrived, self.committed)
        self.lost_in_transit = self.committed - self.delivered
        surplus = min(self.ready, max(0, -self.to_make))
        self.made -= surplus
        return surplus

    def brief(self, now_s: float, cycling: bool) -> GoalBrief:
        """Its entry in the heartbeat.

        Args:
            now_s: the present time.
            cycling: whether the running cycle is for it.
        """
        to_begin = max(0, self.to_make - cycling)
        return GoalBrief(
            goal=self.id,
            product=self.work.product,
            quantity=self.work.quantity,
            made=self.reported_made,
            delivered=self.delivered,
            deadline_s=self.deadline_s,
            offered=True if self.is_offered(now_s) else UNSET,
            to_begin=UNSET if to_begin == self.work.quantity - self.reported_made else to_begin,
            held=self.held if self.taken_over else UNSET,
            holder=self.strategist if self.taken_over else UNSET,
        )

    @property
    def reported_made(self) -> int:
        """Pieces made, without counting replaced ones twice."""
        return min(self.made, self.work.quantity)

    def memory(self) -> GoalMemory:
        return GoalMemory(
            goal=self.id,
            work=self.work,
            strategist=self.strategist,
            deadline_s=self.deadline_s,
            made=self.made,
            delivered=self.delivered,
            lost_in_transit=self.lost_in_transit,
            epoch=self.epoch,
            number=self.number,
            confirmed=self.confirmed,
            held=self.held,
            taken_over=self.taken_over,
            disputes=self.disputes,
            by_people=self.by_people,
            promised_s=self.promised_s,
            came_before=self.came_before,
        )
