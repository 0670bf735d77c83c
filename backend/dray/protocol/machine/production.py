"""A machine's goals: what it has promised to make, how far it is, and what that takes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from msgspec import UNSET

from dray.memory import GoalMemory
from dray.messages import Confirmed, GoalBrief, Production, ProductionCost
from dray.plant import Plant
from dray.protocol.machine.products import Products
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
        "committed",
        "confirmed",
        "credited",
        "deadline_s",
        "delivered",
        "epoch",
        "given_back_s",
        "heard_s",
        "id",
        "lost_in_transit",
        "made",
        "number",
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
        self.credited: dict[str, int] = {}
        """Pieces of handovers that this life has accepted, by vehicle."""
        self.heard_s = -NEVER_S
        """When the strategist has last told what has arrived."""

    @property
    def to_make(self) -> int:
        return self.work.quantity - self.made + self.lost_in_transit

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
        return not (self.ready or self.on_the_way) or now_s >= self.given_back_s + GOODS_LEAVE_S

    def lose(self, pieces: int) -> None:
        """Pieces on the way will not arrive."""
        self.lost_in_transit += pieces

    def on_count(self, confirmed: Confirmed, now_s: float) -> None:
        """The strategist tells what the gate has counted; counts only ever grow."""
        if confirmed.arrived >= self.arrived:
            self.arrived = confirmed.arrived
            self.brought = {each.vehicle: each.pieces for each in confirmed.brought}
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
        if self.on_the_way or arrived == self.delivered:
            return 0
        # Whatever was sent has either arrived or will not: no piece is in between.
        self.delivered = min(arrived, self.committed)
        self.lost_in_transit = self.committed - self.delivered
        surplus = min(self.ready, max(0, -self.to_make))
        self.made -= surplus
        return surplus

    def brief(self, now_s: float) -> GoalBrief:
        """What the heartbeat tells of it."""
        return GoalBrief(
            goal=self.id,
            product=self.work.product,
            quantity=self.work.quantity,
            made=self.told_made,
            delivered=self.delivered,
            deadline_s=self.deadline_s,
            offered=True if self.is_offered(now_s) else UNSET,
        )

    @property
    def told_made(self) -> int:
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
        )


class GoalBook:
    """The goals of one machine, most urgent first.

    Args:
        machine: whose goals.
        plant: what it was set up for.

    Attributes:
        products: what it can make.
    """

    def __init__(self, machine: str, plant: Plant) -> None:
        self.products = Products(machine, plant)
        self._goals: dict[str, Goal] = {}
        self._spare: dict[str, int] = {}
        self.speed_frac = 1.0
        """At which part of its speed the machine works."""

    def __iter__(self) -> Iterator[Goal]:
        return iter(self._goals.values())

    def __len__(self) -> int:
        return len(self._goals)

    def get(self, goal: str) -> Goal | None:
        return self._goals.get(goal)

    def add(self, goal: Goal) -> None:
        self._goals[goal.id] = goal
        self.products.note(goal.work.product, goal.work.definition)
        urgent_first = sorted(self._goals.values(), key=lambda each: (each.deadline_s, each.id))
        self._goals = {each.id: each for each in urgent_first}

    def remove(self, goal: str) -> None:
        """Forget a goal; what is ready of it is spare from now on. Unknown is harmless."""
        removed = self._goals.pop(goal, None)
        if removed is not None:
            self.add_spare(removed.work.product, removed.ready)

    def restore(self, memory: GoalMemory) -> Goal:
        """Take up a goal of an earlier life; what was allowed then is allowed now.

        Pieces that are on the way are to be added to what is committed.
        """
        goal = Goal(
            memory.goal, memory.work, memory.deadline_s, memory.strategist, memory.epoch, memory.number
        )
        goal.confirmed = memory.confirmed
        goal.made, goal.delivered, goal.lost_in_transit = (
            memory.made,
            memory.delivered,
            memory.lost_in_transit,
        )
        goal.committed = memory.delivered + memory.lost_in_transit
        self.add(goal)
        return goal

    def add_spare(self, product: str, pieces: int) -> None:
        """Finished pieces lie there that belong to no goal: its machine or its goal has failed."""
        self._spare[product] = self._spare.get(product, 0) + pieces

    def spare(self, product: str) -> int:
        """Pieces that belong to no goal."""
        return self._spare.get(product, 0)

    def set_spare(self, product: str, pieces: int) -> None:
        """So many pieces belong to no goal: they were counted."""
        self._spare[product] = pieces

    def take_spare(self, product: str, pieces: int) -> None:
        """Pieces that belonged to no goal leave the machine."""
        self._spare[product] -= pieces

    def use_spare(self, goal: Goal, running: Goal | None = None) -> int:
        """Give spare pieces to a goal; returns how many.

        Args:
            goal: which.
            running: the goal whose next piece is being made: that one needs a piece less.
        """
        product = goal.work.product
        missing = goal.to_make - (1 if goal is running else 0)
        pieces = max(0, min(self.spare(product), missing))
        if pieces:
            self._spare[product] -= pieces
            goal.made += pieces
        return pieces

    @property
    def unfinished(self) -> bool:
        """Whether anything is still to be made."""
        return any(goal.to_make > 0 for goal in self.at_work())

    def next_to_make(self, stock: Mapping[str, int]) -> Goal | None:
        """The most urgent goal for whose next piece everything is at hand."""
        for goal in self.at_work():
            if goal.to_make > 0 and _at_hand(goal.work, stock):
                return goal
        return None

    def need(self, material: str, cycling: str) -> int:
        """Pieces of a material that all goals still take out of the buffer.

        Args:
            material: which.
            cycling: the product of the running cycle, whose material is out already; empty for none.
        """
        pieces = 0
        for goal in self.at_work():
            per_piece = _per_piece(goal.work, material)
            if per_piece:
                running = 1 if goal.work.product == cycling else 0
                pieces += per_piece * max(0, goal.to_make - running)
                # One cycle runs at a time: only the first goal of that product has it.
                cycling = "" if running else cycling
        return pieces

    def use_per_s(self, material: str) -> float:
        """Pieces per second at full speed, of the hungriest goal that is still to be made."""
        rates = [
            _per_piece(goal.work, material) / self.cycle_s(goal.work)
            for goal in self.at_work()
            if goal.to_make > 0
        ]
        return max(rates, default=0.0)

    def quote(self, work: Production, stock: Mapping[str, int], lead_time_s: float) -> ProductionCost:
        """What it would take to make `work` after everything that was promised before.

        Args:
            work: what is asked for.
            stock: pieces at hand.
            lead_time_s: how long missing material takes to come.
        """
        waits_s = [goal.to_make * self.cycle_s(goal.work) for goal in self._goals.values()]
        queue_s = sum(waits_s, start=0.0)
        to_make = max(0, work.quantity - self.spare(work.product))
        # While it works at other goals the material for this one is on its way.
        missing = to_make > 0 and not _at_hand(work, stock)
        return ProductionCost(
            queue_s=queue_s,
            material_s=max(0.0, lead_time_s - queue_s) if missing else 0.0,
            making_s=to_make * self.cycle_s(work),
        )

    def cycle_s(self, work: Production) -> float:
        """How long a piece takes at the present speed."""
        return self.products.cycle_s(work) / self.speed_frac

    def slack_s(self, now_s: float) -> float:
        """How much later than now all of it could begin and still be in time; below 0 when something is late."""
        left_s, done_s = float("inf"), now_s
        for goal in self.confirmed():
            done_s += max(0, goal.to_make) * self.cycle_s(goal.work)
            left_s = min(left_s, goal.deadline_s - done_s)
        return left_s

    # --- when it does not work at them ---

    def give_back(self, keep: Goal | None, now_s: float) -> bool:
        """Let others make what is missing of all goals but one; returns whether that is news."""
        news = False
        for goal in self._goals.values():
            if goal is not keep and goal.given_back_s is None:
                goal.given_back_s, news = now_s, True
        return news

    def take_back(self) -> bool:
        """Work at all of them again; returns whether that is news."""
        given_back = [goal for goal in self._goals.values() if goal.given_back_s is not None]
        for goal in given_back:
            goal.given_back_s = None
        return bool(given_back)

    def briefs(self, now_s: float) -> tuple[GoalBrief, ...]:
        """What the heartbeat tells of them."""
        return tuple(goal.brief(now_s) for goal in self._goals.values())

    def memories(self) -> tuple[GoalMemory, ...]:
        """What the next life must know, those that are not confirmed yet too: their strategist may count on them."""
        return tuple(goal.memory() for goal in self)

    def confirmed(self) -> Iterator[Goal]:
        """The goals that are this machine's own by its strategist's word, most urgent first."""
        return (goal for goal in self._goals.values() if goal.confirmed)

    def at_work(self) -> Iterator[Goal]:
        """Those of them that are not given back."""
        return (goal for goal in self.confirmed() if goal.given_back_s is None)


def _per_piece(work: Production, material: str) -> int:
    return sum(line.quantity for line in work.definition.bill if line.material == material)


def _at_hand(work: Production, stock: Mapping[str, int]) -> bool:
    return all(stock.get(line.material, 0) >= line.quantity for line in work.definition.bill)
