"""What a customer is told of an order. Pure: computed from facts, and the same for page and API."""

from __future__ import annotations

from enum import StrEnum

import msgspec

from dray.gateway.tracking.eta import ALWAYS, History, Range, Running, Working, eta, rounded
from dray.gateway.tracking.reasons import Doing, Reason, reasons
from dray.store.orders.milestones import OrderTimes
from dray.store.orders.orders import Order
from dray.store.orders.progress import ENDED, OPEN, Goal, OrderStatus

CANNOT_SAY = frozenset({Doing.BROKEN, Doing.SILENT})
"""What a machine may do that leaves nothing to estimate from."""


class StageName(StrEnum):
    """The way of an order, in order."""

    PLACED = "placed"
    PLANNED = "planned"
    IN_PRODUCTION = "in_production"
    ON_ITS_WAY = "on_its_way"
    DELIVERED = "delivered"


class Late(StrEnum):
    """How an order stands to the time by which it is wanted."""

    NO = ""
    MAYBE = "maybe"
    """The end of the range is after it."""
    YES = "yes"
    """All of the range is after it, or it has passed."""


class Facts(msgspec.Struct, frozen=True, kw_only=True):
    """All that is known of an order. Times are wall clock seconds."""

    order: Order
    now_s: float
    names: dict[str, str] = {}
    """Of products, by id."""
    goals: tuple[Goal, ...] = ()
    times: OrderTimes = OrderTimes()
    piece_times_s: dict[str, tuple[float, ...]] = {}
    """Per goal, when its last pieces were made, oldest first."""
    doings: dict[str, Doing] = {}
    """Per goal, what its machine does."""
    lacking: dict[str, tuple[str, ...]] = {}
    """Per goal, the names of the materials for which it waits, as its machine has told."""
    working: dict[str, Working] = {}
    """Per goal, when its machine works; left out for one that never rests."""
    history: History = History()
    waits: bool = False
    """Whether the strategist has said that nobody can make a part of it."""
    held_up: bool = False
    """Whether a transport of its goods has said that it does not go on."""


class TrackedItem(msgspec.Struct, frozen=True):
    """A part of the order."""

    product: str
    name: str
    quantity: int
    made: int
    delivered: int


class Stage(msgspec.Struct, frozen=True):
    """A step of the way."""

    name: StageName
    reached: bool
    at_s: float | None
    """None when it is not reached, or nobody knows any more when it was."""


class Track(msgspec.Struct, frozen=True, kw_only=True):
    """What a customer is told. Times are wall clock seconds."""

    status: OrderStatus
    reference: str | None
    items: tuple[TrackedItem, ...]
    stages: tuple[Stage, ...]
    eta: Range | None
    reasons: tuple[Reason, ...]
    materials: tuple[str, ...]
    """The names of the materials for which it waits, where somebody has told them: a customer may know what goes into the
    product, and nothing of where it is kept, how much of it there is, and who does not bring it."""
    late: Late
    created_at_s: float
    due_at_s: float | None
    delivered_at_s: float | None
    cancelled_at_s: float | None

    @property
    def stage(self) -> StageName:
        """The last one that is reached."""
        return [stage.name for stage in self.stages if stage.reached][-1]

    @property
    def ended(self) -> bool:
        """Whether nothing changes any more."""
        return self.status in ENDED


def track(facts: Facts) -> Track:
    """What a customer is told of these facts."""
    order = facts.order
    expected, why = _eta(facts), _reasons(facts)
    return Track(
        status=order.status,
        reference=order.reference,
        items=tuple(
            TrackedItem(i.product, facts.names.get(i.product, i.product), i.quantity, i.made, i.delivered)
            for i in order.items
        ),
        stages=_stages(facts),
        eta=expected,
        reasons=why,
        materials=_lacking(facts) if Reason.MATERIAL in why else (),
        late=_late(order, expected, facts.now_s),
        created_at_s=order.created_at_s,
        due_at_s=order.due_at_s,
        delivered_at_s=order.delivered_at_s,
        cancelled_at_s=order.cancelled_at_s,
    )


def _running(facts: Facts) -> list[Goal]:
    """The goals that somebody works at, and of which something has still to arrive; parts arrive nowhere."""
    life = max(1, facts.order.incarnation)
    return [
        goal
        for goal in facts.goals
        if goal.item is not None and goal.is_known(life) and not goal.lost and goal.delivered < goal.quantity
    ]


def _making(facts: Facts) -> list[Goal]:
    return [goal for goal in _running(facts) if goal.made < goal.quantity]


def _eta(facts: Facts) -> Range | None:
    order, running = facts.order, _running(facts)
    unknown = any(facts.doings.get(goal.id, Doing.SILENT) in CANNOT_SAY for goal in running)
    if order.status not in OPEN or facts.waits or unknown or not _all_taken(order, running):
        return None
    found = eta(
        [
            Running(
                goal.quantity,
                goal.made,
                goal.promised_at_s,
                facts.piece_times_s.get(goal.id, ()),
                facts.working.get(goal.id, ALWAYS),
            )
            for goal in running
        ],
        facts.history,
        facts.now_s,
    )
    return None if found is None else rounded(found)


def _all_taken(order: Order, running: list[Goal]) -> bool:
    """Whether somebody works at every piece that has not arrived."""
    coming = [0] * len(order.items)
    for goal in running:
        if goal.item is not None and 0 <= goal.item < len(coming):
            coming[goal.item] += goal.quantity - goal.delivered
    return all(outstanding <= taken for outstanding, taken in zip(order.outstanding, coming, strict=True))


def _reasons(facts: Facts) -> tuple[Reason, ...]:
    if facts.order.status in ENDED:
        return ()
    return reasons(
        released=facts.order.status is not OrderStatus.STORED,
        waits=facts.waits,
        lost=any(goal.lost for goal in facts.goals),
        held_up=facts.held_up,
        lacks=bool(_lacking(facts)),
        doings=[facts.doings.get(goal.id, Doing.SILENT) for goal in _making(facts)],
    )


def _lacking(facts: Facts) -> tuple[str, ...]:
    """Each material once. Who is silent or broken has told of it too long ago."""
    waiting = [goal for goal in _making(facts) if facts.doings.get(goal.id) in {Doing.STARVED, Doing.BUSY}]
    return tuple(dict.fromkeys(name for goal in waiting for name in facts.lacking.get(goal.id, ())))


def _stages(facts: Facts) -> tuple[Stage, ...]:
    order, times = facts.order, facts.times
    at_it = any(facts.doings.get(goal.id) in {Doing.MAKING, Doing.STARVED} for goal in _making(facts))
    made = any(item.made for item in order.items)
    arrived = any(item.delivered for item in order.items)
    told = [
        (StageName.PLACED, True, order.created_at_s),
        (StageName.PLANNED, any(goal.incarnation for goal in facts.goals), times.planned_at_s),
        (StageName.IN_PRODUCTION, made or at_it, times.first_piece_at_s),
        (StageName.ON_ITS_WAY, arrived or times.left_at_s is not None, times.left_at_s),
        (StageName.DELIVERED, order.status is OrderStatus.DELIVERED, order.delivered_at_s),
    ]
    # Who has come to a step has passed those before it, whatever was heard of them.
    last = max(index for index, (_, reached, _) in enumerate(told) if reached)
    return tuple(
        Stage(name, index <= last, at_s if index <= last else None)
        for index, (name, _, at_s) in enumerate(told)
    )


def _late(order: Order, expected: Range | None, now_s: float) -> Late:
    due_s = order.due_at_s
    if due_s is None or order.status is OrderStatus.CANCELLED:
        return Late.NO
    if order.delivered_at_s is not None:
        return Late.YES if order.delivered_at_s > due_s else Late.NO
    if now_s > due_s or (expected is not None and expected.from_s > due_s):
        return Late.YES
    return Late.MAYBE if expected is not None and expected.to_s > due_s else Late.NO
