"""A machine's goals: their progress, and the time they take."""

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
"""Maximum rest in a quote (s), for a rest without a known end."""

PASSED_FRAC = 0.25
"""Price of a second of other work that has to wait: of two idle machines the less busy one is asked."""


class GoalBook:
    """The goals of one machine, most urgent first.

    Args:
        machine: the machine's id.
        plant: the plant with its products.

    Attributes:
        products: the products that it can make.
        working_time: its working time.
        spares: by product: pieces that belong to no goal; only this class changes them.
        promised: how many spare pieces are set aside for others.
    """

    def __init__(self, machine: str, plant: Plant) -> None:
        self.products = Products(machine, plant)
        self.working_time = plant.working_time_of(machine)
        self._goals: dict[str, Goal] = {}
        self.spares: dict[str, int] = {}
        self.promised: Callable[[str], int] = lambda _product: 0
        self.speed_frac = 1.0
        """The machine's speed as a fraction of its full speed."""

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
        """Change the quantity or deadline of a goal; returns whether that is new."""
        if (goal.work.quantity, goal.deadline_s) == (quantity, deadline_s):
            return False
        goal.work, goal.deadline_s = replace(goal.work, quantity=quantity), deadline_s
        self._sort()
        return True

    def _sort(self) -> None:
        urgent_first = sorted(self._goals.values(), key=lambda each: (each.deadline_s, each.id))
        self._goals = {each.id: each for each in urgent_first}

    def remove(self, goal: str) -> None:
        """Forget a goal; its ready pieces become spare. Ignored if unknown."""
        removed = self._goals.pop(goal, None)
        if removed is not None:
            self.add_spare(removed.work.product, removed.ready)

    def restore(self, memory: GoalMemory) -> Goal:
        """Restore a goal of an earlier life without checking it again.

        The caller adds pieces on the way to the committed ones.
        """
        goal = Goal(
            memory.goal, memory.work, memory.deadline_s, memory.strategist, memory.epoch, memory.number
        )
        goal.confirmed, goal.held, goal.disputes = memory.confirmed, memory.held, memory.disputes
        goal.taken_over, goal.by_people = memory.taken_over or memory.held > 1, memory.by_people
        goal.promised_s, goal.came_before = memory.promised_s, memory.came_before
        goal.made, goal.delivered, goal.lost_in_transit = (
            memory.made,
            memory.delivered,
            memory.lost_in_transit,
        )
        goal.committed = memory.delivered + memory.lost_in_transit
        self.add(goal)
        return goal

    def add_spare(self, product: str, pieces: int) -> None:
        """Add finished pieces that belong to no goal."""
        self.spares[product] = self.spares.get(product, 0) + pieces

    def spare(self, product: str) -> int:
        """Pieces that belong to no goal."""
        return self.spares.get(product, 0)

    def free(self, product: str) -> int:
        """Pieces that belong to no goal and are not set aside."""
        return max(0, self.spare(product) - self.promised(product))

    def set_spare(self, product: str, pieces: int) -> None:
        """Set the counted pieces that belong to no goal."""
        self.spares[product] = pieces

    def take_spare(self, product: str, pieces: int) -> None:
        """Spare pieces leave the machine."""
        self.spares[product] -= pieces

    def use_spare(self, goal: Goal, running: Goal | None = None) -> int:
        """Give spare pieces to a goal; returns how many.

        Args:
            goal: the goal.
            running: the goal of the running cycle, which needs one piece less.
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
        """Whether any piece is still to be made."""
        return any(goal.to_make > 0 for goal in self.at_work())

    def next_to_make(
        self, stock: Mapping[str, int], ready: Callable[[Production], bool] = lambda _work: True
    ) -> Goal | None:
        """The most urgent goal with all material for its next piece, and that is `ready` otherwise."""
        for goal in self.at_work():
            if goal.to_make > 0 and at_hand(goal.work, stock) and ready(goal.work):
                return goal
        return None

    def need(self, material: str, cycling: str) -> int:
        """Pieces of a material that all goals still take out of the buffer.

        Args:
            material: the material.
            cycling: the product of the running cycle, whose material is already out; empty for none.
        """
        pieces = 0
        for goal in self.at_work():
            takes = per_piece(goal.work, material)
            if takes and goal.to_make > 0:
                running = 1 if goal.work.product == cycling else 0
                pieces += takes * (goal.to_make - running)
                # One cycle runs at a time: only the first goal of that product with a piece to make has it.
                cycling = "" if running else cycling
        return pieces

    def use_per_s(self, material: str) -> float:
        """Maximum use by any unfinished goal at full speed (pieces/s)."""
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
        """The cost of making `work` after all more urgent goals.

        Args:
            work: the requested goal.
            stock: available pieces.
            lead_time_s: lead time of missing material.
            deadline_s: its deadline: later goals wait for it.
            now_s: the present time; rests before its end count.
        """
        queue_s = passed_s = 0.0
        for goal in self._goals.values():
            left_s = goal.to_make * self.cycle_s(goal.work)
            if goal.deadline_s <= deadline_s:
                queue_s += left_s
            else:
                passed_s += PASSED_FRAC * left_s
        to_make = work.quantity if work.part_of else max(0, work.quantity - self.free(work.product))
        # Its material comes while the machine works at other goals.
        missing = to_make > 0 and not at_hand(work, stock)
        material_s = max(0.0, lead_time_s - queue_s) if missing else 0.0
        making_s = to_make * self.cycle_s(work)
        works_s = queue_s + material_s + making_s
        # An endless rest gets a finite maximum.
        rest_s = min(self.working_time.rests_s(now_s, works_s), REST_MAX_S)
        return ProductionCost(
            queue_s=queue_s, material_s=material_s, making_s=making_s, passed_s=passed_s, rest_s=rest_s
        )

    def cycle_s(self, work: Production) -> float:
        """Duration of a piece at the present speed (s)."""
        return self.products.cycle_s(work) / self.speed_frac

    def slack_s(self, now_s: float) -> float:
        """How much later all goals could begin and still be in time (s); negative if one is late."""
        left_s, done_s = float("inf"), now_s
        for goal in self.confirmed():
            done_s = self.working_time.after_s(done_s, max(0, goal.to_make) * self.cycle_s(goal.work))
            left_s = min(left_s, goal.deadline_s - done_s)
        return left_s

    # --- goals given back ---

    def give_back(self, goals: Collection[Goal], now_s: float) -> bool:
        """Let others make the missing pieces of some goals; returns whether that is new."""
        kept = [goal for goal in goals if goal.given_back_s is None]
        for goal in kept:
            goal.given_back_s = now_s
        return bool(kept)

    def take_back(self, but: Collection[Goal]) -> bool:
        """Work at all other goals again; returns whether that is new."""
        given_back = [
            each for each in self._goals.values() if each.given_back_s is not None and each not in but
        ]
        for goal in given_back:
            goal.given_back_s = None
        return bool(given_back)

    def briefs(self, now_s: float, running: Goal | None = None) -> tuple[GoalBrief, ...]:
        """The goals' entries in the heartbeat; `running` is the goal of the running cycle."""
        return tuple(goal.brief(now_s, goal is running) for goal in self._goals.values())

    def memories(self) -> tuple[GoalMemory, ...]:
        """The records for the next life, also of unconfirmed goals."""
        return tuple(goal.memory() for goal in self)

    def confirmed(self) -> Iterator[Goal]:
        """Goals that the strategist has confirmed, most urgent first."""
        return (goal for goal in self._goals.values() if goal.confirmed)

    def at_work(self) -> Iterator[Goal]:
        """Confirmed goals that are not given back."""
        return (goal for goal in self.confirmed() if goal.given_back_s is None)
