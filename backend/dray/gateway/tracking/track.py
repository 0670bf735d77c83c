"""The customer's view of an order. Pure: computed from facts, the same for page and API."""

from __future__ import annotations

from enum import StrEnum

import msgspec

from dray.gateway.tracking.eta import ALWAYS, History, Range, Running, Working, eta, rounded
from dray.gateway.tracking.reasons import Doing, Reason, reasons
from dray.store.orders.milestones import MovedPromise, OrderTimes
from dray.store.orders.orders import Order
from dray.store.orders.progress import ENDED, OPEN, Goal, OrderStatus

CANNOT_SAY = frozenset({Doing.BROKEN, Doing.SILENT})
"""Activities of a machine that allow no estimate."""


class StageName(StrEnum):
    """The stages of an order, in order."""

    PLACED = "placed"
    PLANNED = "planned"
    IN_PRODUCTION = "in_production"
    ON_ITS_WAY = "on_its_way"
    DELIVERED = "delivered"


class Late(StrEnum):
    """An order's estimate against its due time."""

    NO = ""
    MAYBE = "maybe"
    """The end of the range is later."""
    YES = "yes"
    """The whole range is later, or the due time has passed."""


class Facts(msgspec.Struct, frozen=True, kw_only=True):
    """All facts about an order. Times are wall clock seconds."""

    order: Order
    now_s: float
    names: dict[str, str] = {}
    """Product names, by id."""
    goals: tuple[Goal, ...] = ()
    times: OrderTimes = OrderTimes()
    piece_times_s: dict[str, tuple[float, ...]] = {}
    """Per goal, times of its last pieces, oldest first."""
    former: frozenset[str] = frozenset()
    """Goals that ended because the factory was started without a memory of them."""
    doings: dict[str, Doing] = {}
    """Per goal, its machine's activity."""
    begun: bool = False
    """Whether a machine works at it."""
    lacking: dict[str, tuple[str, ...]] = {}
    """Per goal, names of the materials that it waits for, as reported by its machine."""
    working: dict[str, Working] = {}
    """Per goal, its machine's working time; missing if it never rests."""
    ahead_s: dict[str, float] = {}
    """Per goal behind others, its machine's work until all of it is made."""
    moved: dict[str, MovedPromise] = {}
    """Per goal, its machine's promise, if it was moved since the machine took the goal."""
    speed: float = 1.0
    """Plant seconds per wall second."""
    history: History = History()
    waits: bool = False
    """Whether the strategist has reported that no machine can make a part of it."""
    held_up: bool = False
    """Whether a transport of its goods has reported a halt."""


class TrackedItem(msgspec.Struct, frozen=True):
    """A part of the order."""

    product: str
    name: str
    quantity: int
    made: int
    delivered: int


class Stage(msgspec.Struct, frozen=True):
    """A stage of the order."""

    name: StageName
    reached: bool
    at_s: float | None
    """None if not reached, or if the time is unknown."""


class Track(msgspec.Struct, frozen=True, kw_only=True):
    """The customer's view. Times are wall clock seconds."""

    status: OrderStatus
    reference: str | None
    items: tuple[TrackedItem, ...]
    stages: tuple[Stage, ...]
    eta: Range | None
    reasons: tuple[Reason, ...]
    materials: tuple[str, ...]
    """Names of the missing materials, if reported. A customer may know what the product contains, but not
    where it is kept, how much there is, or which vehicle fails to bring it."""
    late: Late
    created_at_s: float
    due_at_s: float | None
    delivered_at_s: float | None
    cancelled_at_s: float | None

    @property
    def stage(self) -> StageName:
        """The last stage reached."""
        return [stage.name for stage in self.stages if stage.reached][-1]

    @property
    def ended(self) -> bool:
        """Whether the order has ended."""
        return self.status in ENDED


def track(facts: Facts) -> Track:
    """The customer's view of these facts."""
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
    """Goals in work with outstanding pieces; parts of products do not count."""
    life = max(1, facts.order.incarnation)
    return [
        goal
        for goal in facts.goals
        if goal.item is not None and goal.is_known(life) and not goal.lost and goal.delivered < goal.quantity
    ]


def _making(facts: Facts) -> list[Goal]:
    return [goal for goal in _running(facts) if goal.made < goal.quantity]


def _promised_s(facts: Facts, goal: Goal) -> float | None:
    """The promise of a goal that holds now."""
    moved = facts.moved.get(goal.id)
    return goal.promised_at_s if moved is None else moved.promised_at_s(facts.speed)


def _is_overtaken(facts: Facts, goal: Goal) -> bool:
    """Whether a goal waits for more urgent ones that came since it was taken, and its promise was moved by that."""
    moved, first_s = facts.moved.get(goal.id), goal.promised_at_s
    return (
        moved is not None
        and moved.came_before > 0
        and (first_s is None or moved.promised_at_s(facts.speed) > first_s)
        and facts.doings.get(goal.id) is Doing.BUSY
    )


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
                _promised_s(facts, goal),
                goal.id in facts.moved,
                facts.piece_times_s.get(goal.id, ()),
                facts.working.get(goal.id, ALWAYS),
                facts.ahead_s.get(goal.id, 0.0),
            )
            for goal in running
        ],
        facts.history,
        facts.now_s,
    )
    return None if found is None else rounded(found)


def _all_taken(order: Order, running: list[Goal]) -> bool:
    """Whether a machine works at every outstanding piece."""
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
        started_anew=bool(facts.former),
        overtaken=any(_is_overtaken(facts, goal) for goal in _making(facts)),
        doings=[facts.doings.get(goal.id, Doing.SILENT) for goal in _making(facts)],
    )


def _lacking(facts: Facts) -> tuple[str, ...]:
    """Each missing material once. Reports of silent or broken machines are too old."""
    waiting = [goal for goal in _making(facts) if facts.doings.get(goal.id) in {Doing.STARVED, Doing.BUSY}]
    return tuple(dict.fromkeys(name for goal in waiting for name in facts.lacking.get(goal.id, ())))


def _stages(facts: Facts) -> tuple[Stage, ...]:
    order, times = facts.order, facts.times
    made = any(item.made for item in order.items)
    arrived = any(item.delivered for item in order.items)
    told = [
        (StageName.PLACED, True, order.created_at_s),
        (
            StageName.PLANNED,
            any(goal.incarnation and goal.id not in facts.former for goal in facts.goals),
            times.planned_at_s,
        ),
        (StageName.IN_PRODUCTION, made or facts.begun, times.first_piece_at_s),
        # The same as the order's status says to everybody else.
        (StageName.ON_ITS_WAY, arrived or order.status is OrderStatus.IN_DELIVERY, times.left_at_s),
        (StageName.DELIVERED, order.status is OrderStatus.DELIVERED, order.delivered_at_s),
    ]
    # A stage reached includes all stages before it, reported or not.
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
