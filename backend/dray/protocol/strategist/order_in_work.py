"""An order that the strategist works at, and its goals."""

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
        """Who makes it; empty while nobody has taken it."""
        self.epoch = 1
        """Of its announcement: one that an earlier life has made is not answered to any more."""
        self.arrived = 0
        """Pieces that the gate has counted; of a part, those that its machine has made."""
        self.brought: dict[str, int] = {}
        """The same by vehicle, as far as this life has heard it."""
        self.by_people = False
        """People count at the gate, later than goods come."""
        self.asked: int | None = None
        """As little as its machine is asked to make of it, by a change that is under way."""
        self.keeps = False
        """It has said that it can spare no more."""
        self.named_s = 0.0
        """When its machine has last said that it has this goal (plant clock)."""
        self.offered = False
        """Its machine asks that others make what is missing."""
        self.failure: Reason | None = None
        """Why it is being taken from its machine; the gate's last count is awaited."""
        self.waits = False
        """Whether it was said that nobody can make it."""
        self.to_begin = work.quantity
        """Pieces whose material is not taken yet, by its machine's word."""
        self.taken_s: float | None = None
        """When a machine has taken it, as far as this life has seen it."""

    def booked(self) -> GoalBooked:
        """What the next life must know of it."""
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
        """How often it was released, with this time."""
        self.goals: dict[str, OpenGoal] = {}
        """Those that are not delivered."""
        self.revoked_by = ""
        """Who has taken it back: then it ends when no goal is open any more. Empty while it is worked at."""
        self.withdrawn = [0] * len(items)
        """Per item, pieces of goals that were withdrawn and had not arrived."""
        self.change = 0
        """How often people have changed it."""
        self.parts: dict[str, ProductDefinition] = {}
        """Definitions of parts that it has brought."""
        self.wanted: list[int] = []
        """Per item, the pieces that a change asks for, while machines are asked what they keep; empty when none is under way."""

    @property
    def quantities(self) -> tuple[int, ...]:
        """Per item, all that will have been delivered, with what had arrived before this release."""
        return tuple(item.arrived + item.quantity for item in self.items)

    @property
    def goals_of_parts(self) -> list[OpenGoal]:
        """Those whose pieces go to no customer."""
        return [goal for goal in self.goals.values() if goal.work.part_of]

    @property
    def is_delivered(self) -> bool:
        """Whether no goal is open whose pieces go to the customer."""
        return all(goal.work.part_of for goal in self.goals.values())
