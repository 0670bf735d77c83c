"""An order in work, and its goals."""

from __future__ import annotations

from dray.memory import GoalBooked
from dray.messages import OrderItem, ProductDefinition, Production, Reason


class OpenGoal:
    """A goal that is not delivered yet."""

    __slots__ = (
        "arrived",
        "asked",
        "brought",
        "by_people",
        "deadline_s",
        "epoch",
        "failure",
        "id",
        "keeps",
        "machine",
        "named_s",
        "offered",
        "taken_s",
        "to_begin",
        "waits",
        "work",
    )

    def __init__(self, goal: str, work: Production, deadline_s: float) -> None:
        self.id = goal
        self.work = work
        self.deadline_s = deadline_s
        self.machine = ""
        """The machine that makes it; empty for none."""
        self.epoch = 1
        """Epoch of its announcement; answers to an earlier life's announcement are ignored."""
        self.arrived = 0
        """Pieces that the gate has counted; for a part, those that its machine has made."""
        self.brought: dict[str, int] = {}
        """Arrived pieces by vehicle, as far as this life has heard."""
        self.by_people = False
        """Whether people count at the gate, later than goods come."""
        self.asked: int | None = None
        """The quantity to which a change asks its machine to reduce it; None for none."""
        self.keeps = False
        """Whether its machine has answered that it can save no more."""
        self.named_s = 0.0
        """When its machine last named this goal (plant clock)."""
        self.offered = False
        """Whether its machine asks that others make the missing pieces."""
        self.failure: Reason | None = None
        """Why it is being taken from its machine, while the gate's last count is awaited."""
        self.waits = False
        """Whether it was reported that no machine can make it."""
        self.to_begin = work.quantity
        """Pieces whose material is not taken yet, by its machine's report."""
        self.taken_s: float | None = None
        """When a machine has taken it, if this life has seen that."""

    @property
    def is_begun(self) -> bool:
        """Whether its machine has taken the material of a piece, by its report."""
        return self.to_begin < self.work.quantity

    def booked(self) -> GoalBooked:
        """The record for the next life."""
        return GoalBooked(
            goal=self.id,
            work=self.work,
            deadline_s=self.deadline_s,
            machine=self.machine,
            epoch=self.epoch,
            arrived=self.arrived,
        )


class OrderInWork:
    """An order that is not delivered yet."""

    __slots__ = (
        "change",
        "due_s",
        "goals",
        "id",
        "items",
        "parts",
        "release",
        "revoked_by",
        "wanted",
        "withdrawn",
    )

    def __init__(self, order: str, items: tuple[OrderItem, ...], due_s: float, release: int) -> None:
        self.id = order
        self.items = items
        self.due_s = due_s
        self.release = release
        """Number of its releases, including this one."""
        self.goals: dict[str, OpenGoal] = {}
        """Goals that are not delivered."""
        self.revoked_by = ""
        """The agent that has taken it back, and waits until no goal is open; empty for none."""
        self.withdrawn = [0] * len(items)
        """By item: missing pieces of withdrawn goals."""
        self.change = 0
        """Number of changes by people."""
        self.parts: dict[str, ProductDefinition] = {}
        """Definitions of its own parts."""
        self.wanted: list[int] = []
        """By item: the pieces that a change asks for, while machines are asked; empty without a change."""

    @property
    def quantities(self) -> tuple[int, ...]:
        """By item: all pieces that will have been delivered, including those before this release."""
        return tuple(item.arrived + item.quantity for item in self.items)

    @property
    def goals_of_parts(self) -> list[OpenGoal]:
        """Goals whose pieces go to no customer."""
        return [goal for goal in self.goals.values() if goal.work.part_of]

    @property
    def is_delivered(self) -> bool:
        """Whether no goal for the customer is open."""
        return all(goal.work.part_of for goal in self.goals.values())
