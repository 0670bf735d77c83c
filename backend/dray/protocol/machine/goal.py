"""One production goal of a machine: how far it is."""

from __future__ import annotations

from msgspec import UNSET

from dray.memory import GoalMemory
from dray.messages import Confirmed, GoalBrief, Production
from dray.protocol.runtime.events import NEVER_S

GOODS_LEAVE_S = 180.0
"""How long a goal that is given back waits until what was made of it is in: some transports. Then it is made again."""


class Goal:
    """One production goal of a machine. `delivered + lost_in_transit <= committed <= made` at all times.

    Args:
        goal: its name.
        work: what is to be made.
        deadline_s: when it should be done (plant clock).
        strategist: who has given it out.
        epoch, number: of the contract, and of the award by which it was made.
    """

    __slots__ = (
        "arrived",
        "brought",
        "by_people",
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
        "stranded",
        "strategist",
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
        """With which epoch its order is held by `strategist`: another one has taken it over as often as it is higher."""
        self.given_back_s: float | None = None
        """Since when others may make what is missing of it; None while the machine works at it."""
        self.confirmed = False
        """Whether the strategist has heard that it was accepted; nothing is begun before."""
        self.made = 0
        self.committed = 0
        """Pieces that a transport was announced for."""
        self.delivered = 0
        """Pieces that were handed over at the delivery warehouse."""
        self.lost_in_transit = 0
        """Pieces that were sent and will not arrive: they are made once more."""
        self.arrived = 0
        """Pieces that the gate has counted, by the strategist's last word."""
        self.brought: dict[str, int] = {}
        """The same by vehicle, as far as the gate has told."""
        self.by_people = False
        """People count at the gate, later than goods come: its carriers are let go on their word."""
        self.credited: dict[str, int] = {}
        """Pieces of handovers that this life has accepted, by vehicle."""
        self.heard_s = -NEVER_S
        """When the strategist has last told what has arrived."""
        self.disputes = 0
        """Handovers of its pieces, one after the other, of which the gate has counted nothing."""
        self.stranded = 0
        """Pieces on board of failed vehicles, which wait for a person's word."""

    @property
    def to_make(self) -> int:
        return self.work.quantity - self.made + self.lost_in_transit

    @property
    def is_of_parts(self) -> bool:
        """Whether its pieces stay here for whoever fetches them: each is delivered with its making."""
        return bool(self.work.part_of)

    def note_made(self, pieces: int) -> None:
        """Pieces were made, or were there."""
        self.made += pieces
        if self.is_of_parts:
            self.committed += pieces
            self.delivered += pieces

    @property
    def ready(self) -> int:
        """Finished pieces that no transport was announced for."""
        return self.made - self.committed

    @property
    def on_the_way(self) -> int:
        """Pieces of transports that have not ended."""
        return self.committed - self.delivered - self.lost_in_transit

    def is_offered(self, now_s: float) -> bool:
        """Whether others may make what is missing: what was made has left, or that takes too long."""
        if self.given_back_s is None or self.to_make <= 0:
            return False
        if self.stranded:
            return False
        return not (self.ready or self.on_the_way) or now_s >= self.given_back_s + GOODS_LEAVE_S

    def lose(self, pieces: int) -> None:
        """Pieces on the way will not arrive."""
        self.lost_in_transit += pieces

    def on_count(self, confirmed: Confirmed, now_s: float) -> None:
        """The strategist tells what the gate has counted; counts only ever grow."""
        if confirmed.arrived >= self.arrived:
            self.arrived = confirmed.arrived
            self.brought = {each.vehicle: each.pieces for each in confirmed.brought}
        self.by_people = self.by_people or confirmed.by_people
        self.heard_s = now_s

    def arrived_by(self, vehicle: str) -> int:
        """Pieces of a vehicle that have arrived and belong to no handover that was accepted.

        What the gate cannot name a vehicle for may be anybody's.
        """
        named = self.brought.get(vehicle, 0) - self.credited.get(vehicle, 0)
        unnamed = self.arrived - sum(self.brought.values())
        covered = sum(min(pieces, self.brought.get(each, 0)) for each, pieces in self.credited.items())
        used = max(0, self.delivered - covered)
        return max(0, min(max(0, named) + max(0, unnamed - used), self.arrived - self.delivered))

    def deliver(self, vehicle: str, sent: int, counted: int) -> None:
        """A handover was accepted: so many of the pieces that were sent have arrived."""
        self.delivered += counted
        self.lost_in_transit += sent - counted
        self.credited[vehicle] = self.credited.get(vehicle, 0) + counted

    def note_arrived(self, arrived: int) -> int:
        """Believe the gate's count where it is not the machine's own.

        While something is on the way the two may differ, and nothing is changed.

        Returns:
            Ready pieces that are not needed for this goal any more.
        """
        if self.on_the_way or arrived == self.delivered or self.is_of_parts:
            return 0
        if self.by_people and arrived < self.delivered:
            return 0
        # Whatever was sent has either arrived or will not: no piece is in between.
        self.delivered = min(arrived, self.committed)
        self.lost_in_transit = self.committed - self.delivered
        surplus = min(self.ready, max(0, -self.to_make))
        self.made -= surplus
        return surplus

    def brief(self, now_s: float, cycling: bool) -> GoalBrief:
        """What the heartbeat tells of it.

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
            held=UNSET if self.held == 1 else self.held,
        )

    @property
    def reported_made(self) -> int:
        """Pieces that were made, those that got lost not counted twice."""
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
            disputes=self.disputes,
            by_people=self.by_people,
        )
