"""A machine's goals: what it has promised to make, how far it is, and what that takes."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping

from msgspec.structs import replace

from dray.memory import GoalMemory
from dray.messages import GoalBrief, Production, ProductionCost
from dray.plant import Plant
from dray.protocol.machine.goal import GOODS_LEAVE_S as GOODS_LEAVE_S  # noqa: PLC0414 - told from here, too
from dray.protocol.machine.goal import Goal as Goal  # noqa: PLC0414
from dray.protocol.machine.products import Products, at_hand, per_piece
from dray.protocol.runtime.events import NEVER_S

REST_MAX_S = 3660 * 86_400.0
"""What is told of a rest of which no end is known."""

PASSED_FRAC = 0.25
"""What a second of work that must wait for it adds to a price: of two machines that could begin at once, the less busy is asked."""


class GoalBook:
    """The goals of one machine, most urgent first.

    Args:
        machine: whose goals.
        plant: what it was set up for.

    Attributes:
        products: what it can make.
        working_time: when the machine works.
        spares: by product, the pieces that belong to no goal; only this class changes them.
        promised: how many of those are set aside for others.
    """

    def __init__(self, machine: str, plant: Plant) -> None:
        self.products = Products(machine, plant)
        self.working_time = plant.working_time_of(machine)
        self._goals: dict[str, Goal] = {}
        self.spares: dict[str, int] = {}
        self.promised: Callable[[str], int] = lambda _product: 0
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
        self._sort()

    def revise(self, goal: Goal, quantity: int, deadline_s: float) -> bool:
        """Less of a goal is to be made, or at another time; returns whether that is news."""
        if (goal.work.quantity, goal.deadline_s) == (quantity, deadline_s):
            return False
        goal.work, goal.deadline_s = replace(goal.work, quantity=quantity), deadline_s
        self._sort()
        return True

    def _sort(self) -> None:
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
        goal.confirmed, goal.held, goal.disputes = memory.confirmed, memory.held, memory.disputes
        goal.by_people = memory.by_people
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
        self.spares[product] = self.spares.get(product, 0) + pieces

    def spare(self, product: str) -> int:
        """Pieces that belong to no goal."""
        return self.spares.get(product, 0)

    def free(self, product: str) -> int:
        """Pieces that belong to no goal, and are set aside for nobody."""
        return max(0, self.spare(product) - self.promised(product))

    def set_spare(self, product: str, pieces: int) -> None:
        """So many pieces belong to no goal: they were counted."""
        self.spares[product] = pieces

    def take_spare(self, product: str, pieces: int) -> None:
        """Pieces that belonged to no goal leave the machine."""
        self.spares[product] -= pieces

    def use_spare(self, goal: Goal, running: Goal | None = None) -> int:
        """Give spare pieces to a goal; returns how many.

        Args:
            goal: which.
            running: the goal whose next piece is being made: that one needs a piece less.
        """
        product = goal.work.product
        if goal.is_of_parts:
            return 0  # Its strategist has counted on them already.
        missing = goal.to_make - (1 if goal is running else 0)
        pieces = max(0, min(self.free(product), missing))
        if pieces:
            self.spares[product] -= pieces
            goal.made += pieces
        return pieces

    @property
    def unfinished(self) -> bool:
        """Whether anything is still to be made."""
        return any(goal.to_make > 0 for goal in self.at_work())

    def next_to_make(
        self, stock: Mapping[str, int], ready: Callable[[Production], bool] = lambda _work: True
    ) -> Goal | None:
        """The most urgent goal for whose next piece everything is at hand, and that is `ready` otherwise, too."""
        for goal in self.at_work():
            if goal.to_make > 0 and at_hand(goal.work, stock) and ready(goal.work):
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
            takes = per_piece(goal.work, material)
            if takes:
                running = 1 if goal.work.product == cycling else 0
                pieces += takes * max(0, goal.to_make - running)
                # One cycle runs at a time: only the first goal of that product has it.
                cycling = "" if running else cycling
        return pieces

    def use_per_s(self, material: str) -> float:
        """Pieces per second at full speed, of the hungriest goal that is still to be made."""
        hungry = (goal.work for goal in self.at_work() if goal.to_make > 0)
        return max((per_piece(work, material) / self.cycle_s(work) for work in hungry), default=0.0)

    def quote(
        self,
        work: Production,
        stock: Mapping[str, int],
        lead_time_s: float,
        deadline_s: float = NEVER_S,
        now_s: float = 0.0,
    ) -> ProductionCost:
        """What it would take to make `work` after everything that is wanted before it.

        Args:
            work: what is asked for.
            stock: pieces at hand.
            lead_time_s: how long missing material takes to come.
            deadline_s: when it is wanted: what is wanted later waits for it.
            now_s: from when on; the rests that come until it is done count.
        """
        queue_s = passed_s = 0.0
        for goal in self._goals.values():
            left_s = goal.to_make * self.cycle_s(goal.work)
            if goal.deadline_s <= deadline_s:
                queue_s += left_s
            else:
                passed_s += PASSED_FRAC * left_s
        to_make = work.quantity if work.part_of else max(0, work.quantity - self.free(work.product))
        # While it works at other goals the material for this one is on its way.
        missing = to_make > 0 and not at_hand(work, stock)
        material_s = max(0.0, lead_time_s - queue_s) if missing else 0.0
        making_s = to_make * self.cycle_s(work)
        works_s = queue_s + material_s + making_s
        # What never ends is promised for the end of what can be reckoned with.
        rest_s = min(self.working_time.rests_s(now_s, works_s), REST_MAX_S)
        return ProductionCost(
            queue_s=queue_s, material_s=material_s, making_s=making_s, passed_s=passed_s, rest_s=rest_s
        )

    def cycle_s(self, work: Production) -> float:
        """How long a piece takes at the present speed."""
        return self.products.cycle_s(work) / self.speed_frac

    def slack_s(self, now_s: float) -> float:
        """How much later than now all of it could begin and still be in time; below 0 when something is late."""
        left_s, done_s = float("inf"), now_s
        for goal in self.confirmed():
            done_s = self.working_time.after_s(done_s, max(0, goal.to_make) * self.cycle_s(goal.work))
            left_s = min(left_s, goal.deadline_s - done_s)
        return left_s

    # --- when it does not work at them ---

    def give_back(self, goals: Collection[Goal], now_s: float) -> bool:
        """Let others make what is missing of some; returns whether that is news."""
        kept = [goal for goal in goals if goal.given_back_s is None]
        for goal in kept:
            goal.given_back_s = now_s
        return bool(kept)

    def take_back(self, but: Collection[Goal]) -> bool:
        """Work at all others again; returns whether that is news."""
        given_back = [
            each for each in self._goals.values() if each.given_back_s is not None and each not in but
        ]
        for goal in given_back:
            goal.given_back_s = None
        return bool(given_back)

    def briefs(self, now_s: float, running: Goal | None = None) -> tuple[GoalBrief, ...]:
        """What the heartbeat tells of them, one of which may be the one whose piece is in the making."""
        return tuple(goal.brief(now_s, goal is running) for goal in self._goals.values())

    def memories(self) -> tuple[GoalMemory, ...]:
        """What the next life must know, those that are not confirmed yet too."""
        return tuple(goal.memory() for goal in self)

    def confirmed(self) -> Iterator[Goal]:
        """The goals that are this machine's own by its strategist's word, most urgent first."""
        return (goal for goal in self._goals.values() if goal.confirmed)

    def at_work(self) -> Iterator[Goal]:
        """Those of them that are not given back."""
        return (goal for goal in self.confirmed() if goal.given_back_s is None)
