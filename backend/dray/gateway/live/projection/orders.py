"""Orders as panels see them, kept from REST calls and facts, not read from SQL."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterable, Iterator
from heapq import heappop, heappush
from itertools import islice
from typing import ClassVar, get_args

from dray.gateway.live.projection.changes import Changes
from dray.gateway.live.projection.materials import Materials
from dray.gateway.live.reasons import failures_of, told
from dray.gateway.live.views import CauseView, GoalView, OrderItemView, OrderView
from dray.messages import Event, GoalBrief, MachineHeartbeat, MachineStatus, MaterialWait, Reason
from dray.messages.fact import GoalContracted, GoalWaits, OrderAccepted
from dray.store.history.clocks import ToWall
from dray.store.orders.orders import Order, OrderTotals
from dray.store.orders.progress import (
    ENDED,
    OPEN,
    Goal,
    OfGoal,
    OrderStatus,
    accepted_order,
    delivered_after,
    goal_of,
    life_with,
    merge,
    note,
    progress,
    status_after,
)

ENDED_KEPT = 50
"""Ended orders that panels still show; SQL has all."""


class Orders:
    """The orders.

    Args:
        to_wall_s: plant clock to wall clock.
        products: the products that this plant can make.
        materials: the materials' names, and the materials that each product takes.
    """

    heeded: ClassVar[tuple[type, ...]] = (GoalWaits, OrderAccepted, *get_args(OfGoal))
    """Kinds of facts that may change an order."""

    def __init__(
        self, to_wall_s: ToWall, products: Collection[str], materials: Materials | None = None
    ) -> None:
        self._materials = materials or Materials({}, {})
        self._to_wall_s, self._products = to_wall_s, products
        self._orders: dict[str, Order] = {}
        self._goals: dict[str, dict[str, Goal]] = {}
        """Per order kept here, its goals by id."""
        self._order_of: dict[str, str] = {}
        """Per goal kept here, its order."""
        self._waits: dict[str, dict[str, CauseView]] = {}
        """Per order that waits, the goals that no machine can make now, and why."""
        self._lacks: dict[str, dict[str, tuple[MaterialWait, ...]]] = {}
        """Per machine that waits for material, its waiting goals and their materials."""
        self._at_work: dict[str, str] = {}
        """Per machine that works, the goal that it works at."""
        self._work_since_s: dict[str, float] = {}
        """Per goal that a machine works at, since when (wall clock), as far as heard here."""
        self._cut_off: frozenset[str] = frozenset()
        """Places that closures have cut off."""
        self._strange: dict[str, list[str]] = {}
        """Per open order, products that this plant does not make, since its plant file was replaced."""
        self._due: list[tuple[float, str]] = []
        """A heap of the orders before their due time."""
        self._late: set[str] = set()
        """Orders past their due time that were open at the last look."""
        self._ended: dict[str, None] = {}
        """Ended orders, oldest first."""
        self._open_of: Counter[str] = Counter()
        """Open orders, by the caller that placed them."""
        self.delivered, self.on_time = 0, 0
        """Counts over all orders ever."""
        self.changes = Changes("order")

    @property
    def open(self) -> int:
        """Number of open orders."""
        return len(self._orders) - len(self._ended)

    def open_ids(self) -> frozenset[str]:
        """Ids of the orders at which the factory works."""
        return frozenset(name for name, order in self._orders.items() if order.status in OPEN)

    def open_of(self, caller: str) -> int:
        """Number of open orders that a caller placed."""
        return self._open_of[caller]

    @property
    def by_status(self) -> Counter[OrderStatus]:
        """Number of orders kept here, by status."""
        return Counter(order.status for order in self._orders.values())

    def restore(self, orders: Iterable[tuple[Order, Iterable[Goal]]], totals: OrderTotals) -> None:
        """Restore orders from SQL."""
        for order, goals in orders:
            self._keep(order)
            for goal in goals:
                self._attach_goal(order.id, goal)
        self.delivered, self.on_time = totals.delivered, totals.on_time

    def put(self, order: Order, goals: Iterable[Goal] = ()) -> None:
        """Show an order that was placed, released, taken back or cancelled, or that the strategist ended.

        Args:
            order: its state in SQL.
            goals: its goals in SQL, where these may know more than was heard here.
        """
        known = self._orders.get(order.id)
        if known is not None and known.status in ENDED:
            return
        for goal in goals:
            self._attach_goal(order.id, goal)
        if known is not None and order.status is not OrderStatus.CANCELLED:
            # SQL may lag behind what the factory has reported since.
            order = self._advanced(order)
            if order.status is OrderStatus.DELIVERED:
                self._count(order)
        self._keep(order)

    def fold(self, event: Event) -> bool:
        """Take an event in.

        Returns:
            False when it says nothing new about an order kept here.
        """
        if isinstance(event.fact, GoalWaits):
            return self._wait(event, event.fact)
        order = self._orders.get(self._subject(event) or "")
        if order is None or not order.releases:
            return False
        went_on = isinstance(event.fact, GoalContracted) and self._goes_on(order.id, event.fact.goal)
        if accepted_order(event):
            order.incarnation = max(order.incarnation, life_with(event))
        advanced = self._advanced(order)
        if advanced == order and not went_on:
            return False
        if advanced.status is OrderStatus.DELIVERED and order.status is not OrderStatus.DELIVERED:
            self._count(advanced)
        self._keep(advanced)
        return True

    def on_heartbeat(self, heartbeat: MachineHeartbeat) -> None:
        """Take in the goal that a machine works at, and the materials that it and its goals wait for."""
        self._note_work(heartbeat)
        if not heartbeat.waits and heartbeat.machine not in self._lacks:
            return
        before, now = self._lacks.get(heartbeat.machine, {}), self._materials.lacking(heartbeat)
        if now:
            self._lacks[heartbeat.machine] = now
        else:
            self._lacks.pop(heartbeat.machine, None)
        for goal in {**before, **now}:
            order = self._order_of.get(goal)
            if order is not None and before.get(goal) != now.get(goal):
                self.changes.mark(order)

    def _note_work(self, heartbeat: MachineHeartbeat) -> None:
        before = self._at_work.get(heartbeat.machine)
        now = None if heartbeat.status is MachineStatus.ERROR else first_to_make(heartbeat.goals)
        if before == now:
            return
        if before is not None:
            del self._at_work[heartbeat.machine]
            self._work_since_s.pop(before, None)
        if now is not None:
            self._at_work[heartbeat.machine] = now
            self._work_since_s[now] = self._to_wall_s(heartbeat.at_s)
        for goal in (before, now):
            order = self._order_of.get(goal or "")
            if order is not None:
                self.changes.mark(order)

    def work_since_s(self, goal: str) -> float | None:
        """Since when a machine has worked at a goal (wall clock), as far as heard here; None when none does."""
        return self._work_since_s.get(goal)

    def begun(self, order: str) -> bool:
        """Whether a machine works at one of an order's goals.

        Parts for its products do not count, nor do goals that their machines have failed with.
        """
        goals = self._goals.get(order, {}).values()
        own = (goal.id for goal in goals if goal.item is not None and not goal.over)
        return any(goal in self._work_since_s for goal in own)

    def get(self, order: str) -> Order | None:
        """One order, if it is kept here."""
        return self._orders.get(order)

    def due_of(self, goal: str) -> float | None:
        """The due time of a goal's order; None where it is not known."""
        order = self.get(self._order_of.get(goal, ""))
        return None if order is None else order.due_at_s

    def named(self, goal: str) -> tuple[str, str]:
        """The id and the name for people of a goal's order; empty where it is not known."""
        order = self.get(self._order_of.get(goal, ""))
        return ("", "") if order is None else (order.id, order.reference or order.id)

    def waits(self, order: str) -> CauseView | None:
        """Why an order waits; None when it does not, or is not kept here."""
        if strange := self._strange.get(order):
            return told(CauseView(not_made=tuple(strange)))
        return next(iter(self._waits.get(order, {}).values()), None)

    def lacks(self, order: str) -> CauseView | None:
        """The material that an order waits for; None when it waits for none."""
        if not self._lacks:
            return None
        goals = self._goals.get(order, {})
        lacking = (lacks[goal] for lacks in self._lacks.values() for goal in lacks if goal in goals)
        return next((self._materials.cause(waits) for waits in lacking), None)

    def lacking(self, goal: str, machine: str) -> tuple[str, ...]:
        """Names of the materials that a goal waits for, as its machine reported; empty for none."""
        waits = self._lacks.get(machine, {}).get(goal, ())
        return tuple(self._materials.name(wait.item) for wait in waits)

    def cut_off(self, places: Collection[str]) -> None:
        """Set the places that no vehicle can reach: orders with a goal there wait."""
        before, self._cut_off = self._cut_off, frozenset(places)
        if before != self._cut_off:
            for order in self._orders:
                if order not in self._ended:
                    self.changes.mark(order)

    def closed(self, order: str) -> CauseView | None:
        """An order's machines that closures cut off; None without any."""
        if not self._cut_off or order in self._ended:
            return None
        goals = self._goals.get(order, {}).values()
        machines = {goal.machine for goal in goals if goal.delivered < goal.quantity} & self._cut_off
        return told(CauseView(reason=Reason.CLOSED, detail=", ".join(sorted(machines)))) if machines else None

    def why_waits(self, order: str) -> CauseView | None:
        """The reason why an order waits; None when it does not."""
        return self.waits(order) or self.closed(order) or self.lacks(order)

    def impossible(self) -> Collection[str]:
        """Ids of orders that wait for a product that this plant does not make."""
        return self._strange.keys()

    def in_trouble(self, wall_s: float) -> Iterator[OrderView]:
        """Open orders that wait, cannot be made here, or are past their due time."""
        while self._due and self._due[0][0] < wall_s:
            self._late.add(heappop(self._due)[1])
        self._late = {order for order in self._late if order in self._orders and order not in self._ended}
        return (
            self._view(self._orders[order])
            for order in self._strange.keys() | self._waits.keys() | self._late
        )

    def views(self, most: int | None = None) -> tuple[OrderView, ...]:
        """The open orders and the last ended ones; only the first `most` if given."""
        return tuple(self._view(order) for order in islice(self._orders.values(), most))

    def ids(self) -> tuple[str, ...]:
        """The ids of all orders kept here, in the order of `views`."""
        return tuple(self._orders)

    def view(self, order: str) -> OrderView | None:
        """One of them, if it is kept here."""
        kept = self._orders.get(order)
        return None if kept is None else self._view(kept)

    def take_changed(self, most: int | None = None) -> tuple[OrderView, ...]:
        """Orders that changed since the last call; only the first `most` if given."""
        return tuple(self._view(self._orders[order]) for order in self.changes.take_changed(most))

    def _wait(self, event: Event, fact: GoalWaits) -> bool:
        """Note a goal that no machine can make: its order waits until a machine takes it."""
        order = self._orders.get(fact.order)
        goal = self._goals.get(fact.order, {}).get(fact.goal)
        late = goal is not None and goal.has_newer(
            (goal.held, event.incarnation, event.number), self._to_wall_s(event.at_s)
        )
        if order is None or order.status in ENDED or late:
            return False
        waits = self._waits.setdefault(fact.order, {})
        cause = failures_of(fact)
        if waits.get(fact.goal) == cause:
            return False
        waits[fact.goal] = cause
        self.changes.mark(fact.order)
        return True

    def _goes_on(self, order: str, goal: str) -> bool:
        """Note that a machine took a goal; returns whether its order had waited for that."""
        waits = self._waits.get(order, {})
        waited = waits.pop(goal, None) is not None
        if waited and not waits:
            del self._waits[order]
        return waited

    def _view(self, order: Order) -> OrderView:
        return order_view(order, self.why_waits(order.id), begun=self.begun(order.id))

    def _subject(self, event: Event) -> str | None:
        """Note what an event says about a goal; returns its order."""
        name = goal_of(event)
        if name is None:
            return accepted_order(event)
        order = self._order_of.get(name) or getattr(event.fact, "order", None)
        if order is None or order not in self._orders:
            return None
        goals = self._goals.setdefault(order, {})
        if name not in goals:
            self._attach_goal(order, Goal(name))
        note(goals[name], event, self._to_wall_s)
        return order

    def _attach_goal(self, order: str, goal: Goal) -> None:
        merge(self._goals.setdefault(order, {}).setdefault(goal.id, Goal(goal.id)), goal)
        self._order_of[goal.id] = order

    def _advanced(self, order: Order) -> Order:
        """The order with the progress of its goals."""
        known = self._orders.get(order.id, order)
        reached = progress(
            order.quantities,
            self._goals.get(order.id, {}).values(),
            max(order.incarnation, known.incarnation),
            order.delivered,
        )
        items = tuple(
            type(item)(item.product, item.quantity, made, delivered, item.wanted)
            for item, made, delivered in zip(order.items, reached.made, reached.delivered, strict=True)
        )
        fields = {name: getattr(order, name) for name in order.__struct_fields__}
        fields["items"] = items
        status = fields["status"] = status_after(order.status, reached.status)
        fields["delivered_at_s"] = delivered_after(status, order.delivered_at_s, reached.delivered_at_s)
        return Order(**fields)

    def _count(self, order: Order) -> None:
        self.delivered += 1
        if order.due_at_s is None or (order.delivered_at_s or 0.0) <= order.due_at_s:
            self.on_time += 1

    def _keep(self, order: Order) -> None:
        known = self._orders.get(order.id)
        was_open = known is not None and known.status not in ENDED
        self._open_of[order.caller] += (order.status not in ENDED) - was_open
        if not self._open_of[order.caller]:
            del self._open_of[order.caller]
        if order.id not in self._orders and order.due_at_s is not None and order.status not in ENDED:
            heappush(self._due, (order.due_at_s, order.id))
        self._orders[order.id] = order
        self.changes.mark(order.id)
        self._strange.pop(order.id, None)
        if order.status in OPEN and (strange := order.strange_to(self._products)):
            self._strange[order.id] = strange
        if order.status not in OPEN:
            self._waits.pop(order.id, None)
        if order.status in ENDED and order.id not in self._ended:
            self._ended[order.id] = None
            if len(self._ended) > ENDED_KEPT:
                self._forget(next(iter(self._ended)))

    def _forget(self, order: str) -> None:
        del self._ended[order], self._orders[order]
        for goal in self._goals.pop(order, {}):
            del self._order_of[goal]
        self.changes.drop(order)


def first_to_make(goals: Iterable[GoalBrief | GoalView]) -> str | None:
    """The goal that a machine with this queue works at: the first unfinished one; None without any."""
    return next((goal.goal for goal in goals if goal.made < goal.quantity), None)


def goals_before(goal: str, queue: Iterable[GoalView]) -> int:
    """How many unfinished goals a machine makes before one of its queue; 0 where the queue does not have it."""
    before = [each.goal for each in queue if each.made < each.quantity]
    return before.index(goal) if goal in before else 0


def order_view(order: Order, waits: CauseView | None = None, *, begun: bool = False) -> OrderView:
    """An order, as panels see it.

    Args:
        order: the order.
        waits: why it waits; None when it goes on.
        begun: whether a machine works at it.
    """
    return OrderView(
        id=order.id,
        customer=order.customer,
        reference=order.reference,
        status=order.status.value,
        begun=begun or any(item.made for item in order.items),
        items=tuple(
            OrderItemView(
                product=item.product,
                quantity=item.quantity,
                made=item.made,
                delivered=item.delivered,
                wanted=item.wanted,
            )
            for item in order.items
        ),
        created_at_s=order.created_at_s,
        due_at_s=order.due_at_s,
        priority=order.priority.value,
        wanted_at_s=order.wanted_at_s,
        changing=order.being_changed,
        delivered_at_s=order.delivered_at_s,
        releases=order.releases,
        revoked_at_s=order.revoked_at_s,
        waits=waits,
    )
