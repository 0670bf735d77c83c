"""The timeline of an order: goals, transports of finished goods, carriers, and deviations. Pure.

It is folded from agents' facts in the log and the order's data, so it remains after the factory has forgotten
the order. Material is brought for machines, not for orders: its transports are not included.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Literal

import msgspec

from dray.gateway.live.views.base import View
from dray.messages import Phase, Role, Transport
from dray.messages.fact import (
    AnyFact,
    AwardAnswered,
    CarrierChanged,
    GoalContracted,
    GoalLost,
    GoalWaits,
    GoalWithdrawn,
    GoodsDelivered,
    OrderDropped,
    OrderFulfilled,
    OrderReturned,
    PhaseEntered,
    PieceMade,
    PromiseMoved,
    TaskClosed,
    TaskOpened,
)
from dray.store.history.beginnings import Beginning, end_of
from dray.store.history.events import EventRow
from dray.store.orders.progress import Goal

MomentKind = Literal[
    "called",
    "won",
    "called_off",
    "cancelled",
    "planned",
    "moved",
    "waits",
    "began",
    "fetched",
    "handed_over",
    "took_over",
    "announced_anew",
    "withdrawn",
    "arrived",
    "delivered",
    "dropped",
    "returned",
    "started_anew",
]


class LegView(View, kw_only=True):
    """One vehicle's part of a transport."""

    carrier: str
    since_at_s: float
    """When it set off to the source."""
    aboard_at_s: float | None = None
    """When it had the goods; None before."""
    until_at_s: float | None = None
    """When it handed over or was replaced; None while under way."""
    replaced: str = ""
    """Why another vehicle continues; empty for the one that delivers."""


class WayOutView(View, kw_only=True):
    """A transport of finished goods, or of a load called for by a person (then `goal` is empty)."""

    task: str
    goal: str
    item: str
    quantity: int
    source: str
    destination: str
    opened_at_s: float
    closed_at_s: float | None = None
    outcome: Literal["", "delivered", "withdrawn", "started_anew"] = ""
    """`started_anew`: the factory was started without a memory of it."""
    legs: tuple[LegView, ...] = ()
    thing: str = ""
    """People's name for it, if it has no master data."""


class OrderGoalView(View, kw_only=True):
    """A part of an order that one machine makes."""

    goal: str
    product: str
    quantity: int
    machine: str
    """Machine that makes it, or made it last."""
    made: int = 0
    delivered: int = 0
    taken_at_s: float | None = None
    begun_at_s: float | None = None
    """When the first piece was made."""
    last_at_s: float | None = None
    """When the last piece so far was made."""
    promised_at_s: float | None = None
    """When its machine promises all of it to be made: moved when the goals before it change."""
    first_promised_at_s: float | None = None
    """The promise with which the machine took it; None if it was not moved since."""
    came_before: int = 0
    """More urgent goals that have come before it since the machine took it; 0 if its promise was not moved."""
    doing: Literal["", "making", "starved", "busy", "broken", "silent"] = ""
    """The present activity of its machine: `busy` with another goal first. Empty once all is made, or after the end."""
    doing_since_at_s: float | None = None
    """Since when its machine makes it, as far as heard here; None while it does not."""
    behind: int = 0
    """Unfinished goals that its machine makes before it."""
    ended: Literal["", "lost", "withdrawn", "started_anew"] = ""
    """`started_anew`: the factory was started without a memory of it."""
    ended_at_s: float | None = None
    successor: str = ""
    """The goal that continues what was lost."""


class MomentView(View, kw_only=True):
    """An event of an order. Fields that do not belong to its kind are empty."""

    kind: MomentKind
    at_s: float
    task: str = ""
    goal: str = ""
    agent: str = ""
    other: str = ""
    """For a takeover: the replaced carrier. For a moved goal: its previous machine. For a hand-over: the
    place."""
    item: str = ""
    quantity: int = 0
    thing: str = ""
    """People's name for the item, if it has no master data."""
    reason: str = ""
    silent_s: float | None = None


class TimelineView(View, kw_only=True):
    """A whole order, oldest first. Times are wall clock seconds."""

    goals: tuple[OrderGoalView, ...] = ()
    transports: tuple[WayOutView, ...] = ()
    moments: tuple[MomentView, ...] = ()
    is_whole: bool = True
    """Whether all its events were read, or only the first ones."""


_READ = msgspec.json.Decoder(AnyFact)


def timeline(
    rows: Iterable[EventRow],
    goals: Iterable[Goal],
    *,
    is_whole: bool = True,
    speed: float = 1.0,
    beginnings: Sequence[Beginning] = (),
) -> TimelineView:
    """The timeline from these events.

    Args:
        rows: events of one order, in any order.
        goals: its goals in SQL.
        is_whole: whether there are no more events.
        speed: plant seconds per wall second.
        beginnings: the starts of the factory without a memory, oldest first.
    """
    told = _Timeline(goals, speed, beginnings)
    # A simulated plant's clock restarts with every start, while its history is kept.
    in_order = sorted(
        rows, key=lambda each: (each.at_s, each.plant_s, each.agent, each.incarnation, each.number)
    )
    # A vehicle's clock may be ahead of its coordinator's: read the opening before the vehicle's facts.
    opened = TaskOpened.__name__
    for row in sorted(in_order, key=lambda each: each.kind != opened):
        fact = _READ.decode(row.fact)
        if isinstance(fact, PromiseMoved):
            told.on_moved(fact, row.at_s, row.plant_s)
        else:
            told.on(fact, row.at_s, row.agent)
            told.note_end(fact, row.incarnation, row.at_s)
    return told.view(is_whole)


class _Timeline:
    """The events folded so far."""

    def __init__(self, goals: Iterable[Goal], speed: float, beginnings: Sequence[Beginning]) -> None:
        self._speed, self._beginnings = speed, beginnings
        self._ends_s: dict[str, float] = {}
        """Per goal and transport that a beginning of the factory has ended, unless it had ended before: when."""
        self._known = {goal.id: goal for goal in goals}
        self._goals: dict[str, OrderGoalView] = {}
        self._ways: dict[str, WayOutView] = {}
        self._sources: dict[str, tuple[str, ...]] = {}
        """Per transport, its possible sources; the carrier chooses one."""
        self._legs: dict[str, list[LegView]] = {}
        self._moments: list[MomentView] = []
        self._arrived: dict[str, int] = {}
        """Per goal, pieces reported."""

    def note_end(self, fact: AnyFact, incarnation: int, at_s: float) -> None:
        """Note when what an agent's life has opened ended with that life."""
        if isinstance(fact, TaskOpened | GoalContracted):
            name = fact.task if isinstance(fact, TaskOpened) else fact.goal
            ends_s = end_of(self._beginnings, incarnation, at_s)
            if ends_s is not None:
                self._ends_s.setdefault(name, ends_s)

    def _end_former(self) -> None:
        """End what a beginning of the factory has left of earlier lives."""
        moments_s = {each.at_s for each in self._beginnings}
        ended_s: set[float] = set()
        for goal in self._goals.values():
            known = self._known.get(goal.goal)
            told_s = known.told_at_s if known is not None and known.over else None
            ends_s = self._ends_s.get(goal.goal, told_s if told_s in moments_s else None)
            if ends_s is not None and not goal.ended and goal.delivered < goal.quantity:
                goal.ended, goal.ended_at_s = "started_anew", ends_s
                goal.promised_at_s = goal.first_promised_at_s = None
                ended_s.add(ends_s)
        for task, way in self._ways.items():
            ends_s = self._ends_s.get(task)
            if ends_s is not None and way.closed_at_s is None:
                way.outcome, way.closed_at_s = "started_anew", ends_s
                self._end_legs(task, ends_s)
                ended_s.add(ends_s)
        for ends_s in ended_s:
            self._say("started_anew", ends_s)
        if ended_s:
            self._moments.sort(key=lambda moment: moment.at_s)

    def view(self, is_whole: bool) -> TimelineView:
        for task, way in self._ways.items():
            way.legs = tuple(self._legs.get(task, ()))
        for goal, known in self._known.items():
            # Events that are no longer in the log, but in SQL's goals.
            view = self._goals.get(goal)
            if view is None and known.product:
                view = self._goals[goal] = OrderGoalView(
                    goal=goal, product=known.product, quantity=known.quantity, machine=known.machine
                )
            if view is not None:
                view.made, view.delivered = max(view.made, known.made), max(view.delivered, known.delivered)
                is_moved = view.promised_at_s is not None and known.promised_at_s is not None
                if is_moved:
                    view.first_promised_at_s = known.promised_at_s
                else:
                    view.promised_at_s, view.came_before = known.promised_at_s, 0
        self._end_former()
        return TimelineView(
            goals=tuple(self._goals.values()),
            transports=tuple(self._ways.values()),
            moments=tuple(self._moments),
            is_whole=is_whole,
        )

    def on(self, fact: AnyFact, at_s: float, agent: str) -> None:
        match fact:
            case TaskOpened() | AwardAnswered() | PhaseEntered() | CarrierChanged() | TaskClosed():
                self._on_task(fact, at_s, agent)
            case OrderFulfilled():
                # A strategist that was away at the end reports it again.
                if all(moment.kind != "delivered" for moment in self._moments):
                    self._say("delivered", at_s)
            case OrderDropped():
                self._say("dropped", at_s)
                for goal in self._goals.values():
                    if not goal.ended and goal.made < goal.quantity:
                        self._on_end(goal.goal, "withdrawn", at_s)
            case OrderReturned():
                self._say("returned", at_s)
            case _:
                self._on_goal(fact, at_s, agent)

    # --- goals ---

    def on_moved(self, fact: PromiseMoved, at_s: float, plant_s: float) -> None:
        """A machine has moved its promise of a goal that it had taken before."""
        if (goal := self._goals.get(fact.goal)) is not None:
            goal.promised_at_s = at_s + (fact.finish_s - plant_s) / self._speed
            goal.came_before = fact.came_before

    def _on_goal(self, fact: AnyFact, at_s: float, agent: str) -> None:
        match fact:
            case GoalContracted():
                self._on_contract(fact, at_s)
            case PieceMade():
                self._on_piece(fact, at_s, agent)
            case GoodsDelivered():
                # A new holder of the order reports all arrivals again.
                news = fact.delivered - self._arrived.get(fact.goal, 0)
                if news > 0:
                    self._arrived[fact.goal] = fact.delivered
                    self._say("arrived", at_s, goal=fact.goal, item=fact.product, quantity=news)
                if (goal := self._goals.get(fact.goal)) is not None:
                    goal.delivered = max(goal.delivered, fact.delivered)
            case GoalLost():
                self._on_end(fact.goal, "lost", at_s, fact.successor)
            case GoalWithdrawn():
                self._on_end(fact.goal, "withdrawn", at_s)
                self._say("withdrawn", at_s, goal=fact.goal, agent=fact.machine)
            case GoalWaits():
                self._say("waits", at_s, goal=fact.goal)
            case _:
                pass

    def _on_contract(self, fact: GoalContracted, at_s: float) -> None:
        before = next((each for each in self._goals.values() if each.successor == fact.goal), None)
        self._goals[fact.goal] = OrderGoalView(
            goal=fact.goal,
            product=fact.product,
            quantity=fact.quantity,
            machine=fact.machine,
            taken_at_s=at_s,
        )
        said = {"goal": fact.goal, "agent": fact.machine, "item": fact.product}
        if before is None:
            self._say("planned", at_s, quantity=fact.quantity, **said)
        else:
            self._say("moved", at_s, quantity=fact.quantity, other=before.machine, **said)

    def _on_piece(self, fact: PieceMade, at_s: float, agent: str) -> None:
        goal = self._goals.get(fact.goal)
        if goal is None:
            return
        if goal.begun_at_s is None:
            goal.begun_at_s = at_s
            self._say("began", at_s, goal=fact.goal, agent=agent, item=fact.product)
        goal.made, goal.last_at_s = max(goal.made, fact.made), at_s

    def _on_end(
        self, goal: str, ended: Literal["lost", "withdrawn"], at_s: float, successor: str = ""
    ) -> None:
        if (view := self._goals.get(goal)) is not None:
            view.ended, view.ended_at_s, view.successor = ended, at_s, successor

    # --- transports ---

    def _on_task(
        self,
        fact: TaskOpened | AwardAnswered | PhaseEntered | CarrierChanged | TaskClosed,
        at_s: float,
        agent: str,
    ) -> None:
        if isinstance(fact, TaskOpened):
            if isinstance(fact.work, Transport):
                self._on_opened(fact.task, fact.work, at_s)
        elif fact.task in self._ways:
            match fact:
                case AwardAnswered(answer="accepted", role=Role.PRIMARY):
                    way = self._ways[fact.task]
                    self._say(
                        "won",
                        at_s,
                        task=fact.task,
                        goal=way.goal,
                        agent=fact.bidder,
                        item=way.item,
                        quantity=way.quantity,
                    )
                case PhaseEntered():
                    self._on_phase(fact, at_s, agent)
                case CarrierChanged():
                    self._on_change(fact, at_s)
                case TaskClosed():
                    self._on_close(fact, at_s)
                case _:
                    pass

    def _on_opened(self, task: str, work: Transport, at_s: float) -> None:
        """Note a transport's first opening; later rounds of bidding count no more."""
        if task not in self._ways:
            self._sources[task] = work.sources
            self._ways[task] = WayOutView(
                task=task,
                goal=work.goal,
                item=work.item,
                quantity=work.quantity,
                source=work.sources[0],
                destination=work.destination,
                opened_at_s=at_s,
            )

    def _on_phase(self, fact: PhaseEntered, at_s: float, agent: str) -> None:
        legs = self._legs.setdefault(fact.task, [])
        way = self._ways[fact.task]
        if not legs or legs[-1].carrier != agent or legs[-1].until_at_s is not None:
            if fact.phase in (Phase.RETURNING, Phase.HANDING_OVER):
                return  # A late report of a replaced carrier.
            legs.append(LegView(carrier=agent, since_at_s=at_s))
        leg = legs[-1]
        if fact.phase is Phase.APPROACHING and fact.station in self._sources[fact.task]:
            way.source = fact.station
        said = {
            "task": fact.task,
            "goal": way.goal,
            "agent": agent,
            "item": way.item,
            "quantity": way.quantity,
        }
        if fact.phase is Phase.CARRYING and leg.aboard_at_s is None:
            leg.aboard_at_s = at_s
            self._say("fetched", at_s, other=way.source, **said)
        elif fact.phase is Phase.HANDING_OVER:
            leg.until_at_s = at_s
            self._say("handed_over", at_s, other=way.destination, **said)

    def _on_change(self, fact: CarrierChanged, at_s: float) -> None:
        way = self._ways[fact.task]
        for leg in self._legs.get(fact.task, ()):
            if leg.carrier == fact.replaced and leg.until_at_s is None:
                leg.until_at_s, leg.replaced = at_s, fact.reason.value
        self._say(
            "took_over" if fact.carrier else "announced_anew",
            at_s,
            task=fact.task,
            goal=way.goal,
            agent=fact.carrier,
            other=fact.replaced,
            item=way.item,
            quantity=way.quantity,
            reason=fact.reason.value,
            silent_s=fact.silent_s or None,
        )

    def _on_close(self, fact: TaskClosed, at_s: float) -> None:
        way = self._ways[fact.task]
        way.closed_at_s, way.outcome = at_s, fact.outcome
        self._end_legs(fact.task, at_s)

    def _end_legs(self, task: str, at_s: float) -> None:
        for leg in self._legs.get(task, ()):
            if leg.until_at_s is None:
                leg.until_at_s = at_s

    def _say(self, kind: MomentKind, at_s: float, **said: object) -> None:
        self._moments.append(MomentView(kind=kind, at_s=at_s, **said))  # type: ignore[arg-type]
