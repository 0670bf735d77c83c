"""The strategist: it turns sales orders into production goals, and never decides a transport (paper, 3.2).

An order is split into goals (`order_book`). Each goal is put up for auction among the machines for its product
(`goal_auctions`). It is followed until all of it has arrived.

The gate of the delivery warehouses, its body, counts deliveries. The gate is also the fence. A machine that does
not name its goal any more has lost it. The gate is shut for that goal and reports its arrivals, and the rest is put
up under a new name. Anything that the machine still sends finds the gate shut, so every ordered piece is delivered
exactly once (invariant 4). No machine needs a lease: machines go on while the strategist is away. Goals of parts
have no gate (`part_goals`).

An order whose release is revoked ends in the same way (`order_revocations`). The answer is given only when all its
goals were counted. It names the missing pieces, so that another release orders exactly those.

Each of several strategists answers for the orders that it holds, and goes on with those of a silent one
(`order_holding`).

A strategist that is asked to leave takes no order and puts nothing up; it stays while a machine may still answer.

    UNCLAIMED --accepted--> MADE BY A MACHINE --all has arrived--> closed
        ^                      |
        |                      +-- not named for GOAL_SILENCE_S, offered by its machine, or broken
        |                          for BREAKDOWN_S, and another machine could make it: the gate is shut
        +-- the rest, as a new goal --+        (when its order was taken back: no new goal)
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from dray.body import Admit, BodyState, GateState, GoodsArrived, Report
from dray.errors import ProtocolViolation
from dray.memory import Memory
from dray.messages import (
    Accepted,
    Bid,
    Declined,
    GoalRevisionTaken,
    MachineHeartbeat,
    Message,
    OrderCancelled,
    OrderReleased,
    OrderRevoked,
    Reason,
)
from dray.messages.fact import (
    GoalLost,
    GoodsDelivered,
    OrderAccepted,
    OrderTakenOver,
)
from dray.messages.gate import GoalHeld, GoalOf
from dray.messages.keys import STRATEGIST, Keys
from dray.plant import Plant
from dray.protocol.contract_net.trust.assessment import Assessor
from dray.protocol.liveness.suspicion import GOAL_SILENCE_S
from dray.protocol.runtime.agent import AgentBase, Handler
from dray.protocol.runtime.events import Instruct
from dray.protocol.runtime.shutdown import COORDINATOR_LEAVES_WITHIN_S
from dray.protocol.strategist.goal_auctions import GOAL_CHECK, GoalAuctions, GoalTaken
from dray.protocol.strategist.machine_monitor import MachineMonitor
from dray.protocol.strategist.order_book import OpenGoal, OrderBook
from dray.protocol.strategist.order_changes import OrderChanges
from dray.protocol.strategist.order_ends import OrderEnds
from dray.protocol.strategist.order_holding import OrderGranted, OrderHeard, OrderLost, life_of
from dray.protocol.strategist.order_revocations import OrderRevocations
from dray.protocol.strategist.part_goals import PartGoals
from dray.protocol.strategist.shared_orders import SharedOrders

ORDER_ID_MAX = 96
"""Maximum characters of an order's id: its goals' ids begin with it, and have at most 128."""


class Strategist(AgentBase):
    """One plant's strategist.

    Args:
        plant: the plant with its machines and products.
        agent: its id.
        incarnation: how often it has been started.
        others: all other strategists of the plant (`shared_orders`).
    """

    def __init__(
        self, plant: Plant, *, agent: str = STRATEGIST, incarnation: int = 1, others: tuple[str, ...] = ()
    ) -> None:
        super().__init__(agent, incarnation, leaves_within_s=COORDINATOR_LEAVES_WITHIN_S)
        self._plant = plant
        self._keys = Keys(plant.id)
        self._monitor = MachineMonitor(plant)
        alone = "" if incarnation == 1 else f"r{incarnation}"
        life = life_of(agent, incarnation, others) if others else alone
        self._book = OrderBook(plant, self._monitor.machines_for, life)
        self._committers = [self._book.commits]
        self._auctions = GoalAuctions(
            self._keys,
            self._book,
            self._monitor,
            self._life,
            Assessor(plant, self._life),
            self._shutdown,
        )
        self._parts = PartGoals(
            plant,
            self._keys,
            self._book,
            self._auctions,
            self._monitor,
            self._life,
            self._shutdown,
            alone=not others,
        )
        self._shared = (
            SharedOrders(self._keys, self._book, self._life, self._shutdown, others) if others else None
        )
        self._ends = OrderEnds(self._book, self._auctions, self._parts, self._shared, self._life)
        self._changes = OrderChanges(self._book, self._auctions, self._ends, self._life)
        self._revocations = OrderRevocations(self._book, self._auctions, self._parts, self._ends, self._life)
        self._answers: dict[type[Message], Handler] = {
            OrderReleased: self._on_released,
            OrderCancelled: self._revocations.on_cancelled,
            OrderRevoked: self._revocations.on_revoked,
        }
        self._message_handlers = {
            GoalRevisionTaken: self._changes.on_taken,
            Bid: self._auctions.on_bid,
            Accepted: self._auctions.on_accepted,
            Declined: self._auctions.on_declined,
            MachineHeartbeat: self._on_machine,
            **self._parts.message_handlers,
            **self._answers,
        }
        self._report_handlers: dict[type[Report], Callable[[Any, float], None]] = {
            GoodsArrived: self._on_arrived
        }
        self._alarm_handlers = {
            GOAL_CHECK: self._check_goal,
            **self._parts.alarms,
            **self._auctions.alarms,
        }
        self._reactions = {
            GoalTaken: self._on_taken,
            OrderGranted: self._on_granted,
            OrderLost: self._on_lost,
            OrderHeard: self._on_heard,
        }
        if self._shared is not None:
            self._message_handlers = {**self._message_handlers, **self._shared.message_handlers}
            self._report_handlers |= self._shared.report_handlers
            self._alarm_handlers = {**self._alarm_handlers, **self._shared.alarms}
            self._committers.append(self._shared.commits)

    def _start(self, body: BodyState | None, memory: Memory, now_s: float) -> None:
        if not isinstance(body, GateState):
            raise ProtocolViolation(f"{self.id}: a strategist needs a gate, not {body!r}")
        self._monitor.start(now_s)
        self._life.subscribe(self._keys.all_machine_heartbeats)
        self._restore(memory, body, now_s)
        if self._shared is not None:
            self._shared.start(body, now_s)
        self._parts.start(now_s)

    def _restore(self, memory: Memory, gate: GateState, now_s: float) -> None:
        """Continue an earlier life's orders with the arrivals since then."""
        self._book.restore(memory)
        if self._shared is not None:
            self._shared.restore(memory, gate)
        elif not memory:
            # A forgotten life has given out what the gate still admits; its orders come again.
            self._life.do(*(Instruct(Admit(goal=goal, quantity=0)) for goal in gate.arrived))
        for goal in list(self._book):
            if not goal.machine:
                # A forgotten award may be under way: an answer to it comes too late.
                self._book.renew(goal)
                continue
            if goal.work.part_of:
                self._follow(goal, now_s, admit=False)
                continue
            self._follow(goal, now_s, admit=not self._book.order_of(goal).revoked_by)
            self._note_arrived(goal, gate.arrived.get(goal.id, 0))
            if goal.arrived >= goal.work.quantity:
                self._ends.deliver(goal)
        for order in self._book.orders():
            if order.revoked_by:
                self._revocations.shut(order)
        for order in self._book.orders():
            if order.wanted:
                self._changes.settle(order, now_s)
        for product in dict.fromkeys(goal.work.product for goal in self._book):
            self._auctions.ask_next(product, now_s)

    def _is_held(self) -> bool:
        return self._auctions.awaits_answers

    def _on_released(self, sender: str, message: OrderReleased, now_s: float) -> None:
        if self._shutdown.begun:
            # An unanswered order is sent again, to the next life.
            self._life.ignore("an order while the strategist is draining")
            return
        if len(message.order) > ORDER_ID_MAX:
            self._life.ignore("an order whose id is too long for the ids of its goals")
            return
        if not all(self._book.can_be_made(item) for item in message.items):
            self._life.ignore("an order for a product that no machine makes")
            return
        if self._shared is None or self._book.held_with(message.order):
            self._revocations.on_released(message, now_s)
        in_work = self._book.order(message.order)
        if in_work is not None and in_work.release < message.release:
            # The order was never answered as taken back, so its missing pieces are still unknown.
            self._life.ignore("a later release of an order that is in work")
            return
        if in_work is not None and self._changes.on_released(sender, message, in_work, now_s):
            return
        if not self._book.knows(message.order, message.release):
            if self._book.is_full:
                self._life.ignore("an order above the limit of open orders")
                return
            order = self._book.take(message)
            held = self._book.held_with(order.id)
            self._life.record(OrderAccepted(order.id, tuple(order.goals), held))
            for item in message.items:
                self._auctions.ask_next(item.product, now_s)
            self._ends.end_if_done(order)
        self._life.send(sender, self._changes.taken(message.order, message.release, message.change))

    def _was_deaf(self, span_s: float) -> None:
        self._monitor.excuse(span_s)
        self._parts.excuse(span_s)
        if self._shared is not None:
            self._shared.excuse(span_s)
        for goal in self._book:
            goal.named_s += span_s

    # --- orders shared with other strategists ---

    def _on_heard(self, heard: OrderHeard, now_s: float) -> None:
        self._answers[type(heard.message)](heard.sender, heard.message, now_s)

    def _on_granted(self, granted: OrderGranted, now_s: float) -> None:
        """Continue an order that another strategist has begun; a fresh one is handled as with one strategist."""
        held, release = granted.held, granted.release
        is_fresh = held.epoch == 1 and not held.goals and not any(held.arrived) and not held.over
        if is_fresh or release is None or self._book.knows(release.order, release.release):
            return
        order = self._book.take_over(release, held.arrived, held.goals)
        self._life.record(OrderTakenOver(order.id, held.epoch, tuple(order.goals)))
        for goal in order.goals.values():
            if goal.machine:
                self._follow(goal, now_s, admit=False)
        if held.over >= release.release:
            # It was taken back, or has arrived: that is repeated on request, and nothing is made.
            self._revocations.shut(order)
            return
        for known in (*held.done, *held.goals):
            # No other strategist reports what has arrived while none held the order.
            if known.arrived:
                self._tell_arrived(known, release.items[known.of.item].product)
        self._changes.settle(order, now_s)
        if self._book.order(order.id) is order:
            self._ends.end_if_done(order)

    def _tell_arrived(self, goal: GoalHeld, product: str) -> None:
        of, pieces = goal.of, goal.arrived
        told = GoodsDelivered(goal.goal, of.order, of.item, product, quantity=pieces, delivered=pieces)
        self._life.record(told)

    def _on_lost(self, lost: OrderLost, now_s: float) -> None:
        """Another strategist goes on with an order: end its goals here."""
        given_up = self._book.give_up(lost.order)
        goals = () if given_up is None else tuple(given_up.goals.values())
        for goal in goals:
            self._auctions.give_up(goal)
        for product in dict.fromkeys(goal.work.product for goal in goals):
            self._auctions.ask_next(product, now_s)

    # --- goals ---

    def _on_taken(self, change: GoalTaken, now_s: float) -> None:
        self._follow(change.goal, now_s)
        self._auctions.ask_next(change.goal.work.product, now_s)

    def _follow(self, goal: OpenGoal, now_s: float, *, admit: bool = True) -> None:
        goal.named_s = now_s
        if admit and not goal.work.part_of:
            of = None
            if self._shared is not None:
                of = GoalOf(goal.work.order, goal.work.item, goal.machine, goal.epoch)
            self._life.instruct(Admit(goal.id, goal.work.quantity, of))
        self._life.alarm((GOAL_CHECK, goal.id), now_s + GOAL_SILENCE_S)

    def _on_machine(self, _sender: str, heartbeat: MachineHeartbeat, now_s: float) -> None:
        machine = heartbeat.machine
        if not self._monitor.on_heartbeat(heartbeat, now_s):
            self._life.ignore("a heartbeat that a newer one has overtaken")
            return
        self._parts.on_machine(heartbeat, now_s)
        for brief in heartbeat.goals:
            goal = self._book.goal(brief.goal)
            if self._shared is not None and not self._shared.is_judge(machine, brief, now_s):
                continue
            if goal is None:
                # It has not heard that its goal is closed, or was down when others got it.
                self._auctions.say_over(machine, brief)
            elif goal.machine == machine:
                goal.named_s = now_s
                if self._parts.on_brief(goal, brief, now_s):
                    self._ends.deliver(goal)
                if goal.offered is not (brief.offered is True):
                    goal.offered = not goal.offered
                    self._check_goal(goal.id, now_s)
                if not goal.work.part_of:
                    if brief.delivered > goal.arrived and not goal.by_people:
                        # It believes that pieces have arrived which the gate has not counted.
                        self._auctions.confirm(goal)
                    self._changes.on_named(goal, brief, now_s)
            elif goal.machine:
                self._auctions.withdraw(machine, goal.id, goal.epoch)

    def _on_arrived(self, report: GoodsArrived, now_s: float) -> None:
        goal = self._book.goal(report.goal)
        if goal is None:
            self._life.ignore("goods for a goal that is closed")
            return
        order = self._book.order_of(goal)
        goal.by_people = report.by_people
        news = self._note_arrived(goal, report.arrived)
        if news and report.vehicle:
            goal.brought[report.vehicle] = goal.brought.get(report.vehicle, 0) + news
        if goal.arrived >= goal.work.quantity:
            self._ends.deliver(goal)
        elif goal.failure and not report.admitted:
            if self._book.order_of(goal).revoked_by:
                self._revocations.take_out(goal)
                self._auctions.ask_next(goal.work.product, now_s)
            else:
                self._give_to_others(goal, now_s)
        elif news and goal.machine:
            self._auctions.confirm(goal)  # Its carrier waits for that count.
        if order.wanted:
            self._changes.settle(order, now_s)

    def _note_arrived(self, goal: OpenGoal, arrived: int) -> int:
        """Note a count of arrivals; returns the number of new pieces."""
        news, work = arrived - goal.arrived, goal.work
        if news <= 0:
            return 0
        self._book.count(goal, arrived)
        told = GoodsDelivered(goal.id, work.order, work.item, work.product, quantity=news, delivered=arrived)
        self._life.record(told)
        return news

    def _check_goal(self, goal_id: str, now_s: float) -> None:
        """Check whether a goal is still made. If not, and another machine could, have the gate shut for it."""
        goal = self._book.goal(goal_id)
        if goal is None:
            return
        if now_s >= goal.named_s + GOAL_SILENCE_S:
            goal.offered = False  # An old offer: its machine may have forgotten the goal, and can make it like any other.
        # A shut gate is not opened again: an older answer must not count as the last one.
        failure = goal.failure or self._failure(goal, now_s)
        fit = self._monitor.anybody_fit(goal.work, now_s, goal.machine if goal.offered else "")
        if not failure:
            goal.waits = False
        elif goal.work.part_of and fit:
            self._parts.lose(goal)
            return
        elif goal.failure or fit:
            goal.failure = failure
            self._life.instruct(Admit(goal=goal.id, quantity=0))
        else:
            self._auctions.say_waits(goal, now_s)
        self._life.alarm((GOAL_CHECK, goal.id), (now_s if failure else goal.named_s) + GOAL_SILENCE_S)

    def _failure(self, goal: OpenGoal, now_s: float) -> Reason | None:
        """Why a goal is not made any more; None if it is."""
        if now_s >= goal.named_s + GOAL_SILENCE_S:
            return self._monitor.failure(goal.machine, now_s) or Reason.FORGOTTEN
        if self._monitor.is_broken_for_long(goal.machine, now_s):
            return Reason.BROKEN
        return (self._monitor.failure(goal.machine, now_s) or Reason.CLOSED) if goal.offered else None

    def _give_to_others(self, goal: OpenGoal, now_s: float) -> None:
        """The gate is shut and has counted: put the missing pieces up as a new goal."""
        self._auctions.close_goal(goal, "withdrawn")
        successor = self._book.succeed(goal)
        held = self._book.held_with(goal.work.order)
        self._life.record(GoalLost(goal.id, goal.machine, goal.arrived, successor.id, held))
        self._auctions.ask_next(goal.work.product, now_s)
