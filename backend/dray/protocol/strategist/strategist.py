"""The strategist: turns sales orders into production goals, and never decides a transport (paper, 3.2).

An order is split into goals (`order_book`), each goal is put up for auction among the machines that can make
its product (`goal_auctions`), and is followed from then on until all of it has arrived.

What is delivered is counted by the gate of the delivery warehouses, its body. The gate is also the fence.
A machine that does not name its goal any more has lost it: the gate is shut for that goal, says how
much has arrived, and the rest is put up under a new name. Whatever the machine still sends finds the gate
shut, so every ordered piece is delivered exactly once (invariant 4), and no machine needs a lease:
all goes on while the strategist is away.

An order whose start is revoked ends in the same way: the gate is shut for its goals, and what it has
counted by then is the last word. Only when all of them were counted is the answer given, with what is
outstanding, so that another release orders that and no piece more.

One that is asked to leave takes no order and puts nothing up; it stays while a machine may be about to
answer it.

    UNCLAIMED --accepted--> MADE BY A MACHINE --all has arrived--> closed
        ^                      |
        |                      +-- not named for GOAL_SILENCE_S, offered by its machine, or broken
        |                          for BREAKDOWN_S, and somebody else could make it: the gate is shut
        +-- the rest, as a new goal --+        (when its order was taken back: no new goal)
"""

from __future__ import annotations

from dray.body import Admit, BodyState, GateState, GoodsArrived
from dray.errors import ProtocolViolation
from dray.memory import Memory
from dray.messages import (
    Accepted,
    Bid,
    CancellationTaken,
    Declined,
    GoalClosed,
    MachineHeartbeat,
    OrderCancelled,
    OrderReleased,
    OrderRevoked,
    OrderTaken,
    Reason,
    RevocationTaken,
)
from dray.messages.fact import (
    GoalLost,
    GoalWithdrawn,
    GoodsDelivered,
    OrderAccepted,
    OrderDropped,
    OrderFulfilled,
    OrderReturned,
    Outcome,
)
from dray.messages.keys import STRATEGIST, Keys
from dray.plant import Plant
from dray.protocol.contract_net.trust.assessment import Assessor
from dray.protocol.liveness.suspicion import GOAL_SILENCE_S
from dray.protocol.runtime.agent import AgentBase
from dray.protocol.runtime.events import Ignore, Instruct, Record, Send, Subscribe
from dray.protocol.runtime.shutdown import COORDINATOR_LEAVES_WITHIN_S
from dray.protocol.strategist.goal_auctions import GoalAuctions
from dray.protocol.strategist.machine_monitor import MachineMonitor
from dray.protocol.strategist.order_book import OpenGoal, OrderBook, OrderInWork

ORDER_ID_MAX = 96
"""Characters of an order's id: the ids of its goals begin with it, and have at most 128."""

GOAL_CHECK = "goal check"
"""The alarm for looking whether a goal is still made, by goal."""


class Strategist(AgentBase):
    """One plant's strategist.

    Args:
        plant: what can be made where.
        agent: its id.
        incarnation: how often it has been started.
    """

    def __init__(self, plant: Plant, *, agent: str = STRATEGIST, incarnation: int = 1) -> None:
        super().__init__(agent, incarnation, leaves_within_s=COORDINATOR_LEAVES_WITHIN_S)
        self._plant = plant
        self._keys = Keys(plant.id)
        self._monitor = MachineMonitor(plant)
        life = "" if incarnation == 1 else f"r{incarnation}"
        self._book = OrderBook(plant, self._monitor.machines_for, life)
        self._committers = [self._book.commits]
        self._auctions = GoalAuctions(
            agent,
            self._keys,
            self._book,
            self._monitor,
            self._timers,
            self._out,
            Assessor(plant, self._out),
            self._shutdown,
            self._follow,
            incarnation=incarnation,
        )
        self._message_handlers = {
            Bid: self._auctions.on_bid,
            Accepted: self._auctions.on_accepted,
            Declined: self._auctions.on_declined,
            MachineHeartbeat: self._on_machine,
            OrderReleased: self._on_released,
            OrderCancelled: self._on_cancelled,
            OrderRevoked: self._on_revoked,
        }
        self._report_handlers = {GoodsArrived: self._on_arrived}
        self._alarm_handlers = {GOAL_CHECK: self._check_goal, **self._auctions.alarms}

    # --- from life to life ---

    def _start(self, body: BodyState | None, memory: Memory, now_s: float) -> None:
        if not isinstance(body, GateState):
            raise ProtocolViolation(f"{self.id}: a strategist needs a gate, not {body!r}")
        self._monitor.start(now_s)
        self._out.append(Subscribe(self._keys.all_machine_heartbeats))
        self._restore(memory, body, now_s)

    def _restore(self, memory: Memory, gate: GateState, now_s: float) -> None:
        """Go on with what an earlier life was bound by, and with what has arrived since."""
        self._book.restore(memory)
        if not memory:
            # What the gate still lets in was given out by a life that is forgotten, and its orders come again.
            self._out.extend(Instruct(Admit(goal=goal, quantity=0)) for goal in gate.arrived)
        for goal in list(self._book):
            if not goal.machine:
                # An award may be under way that nobody remembers: an answer to it comes too late.
                self._book.renew(goal)
                continue
            self._follow(goal, now_s, admit=not self._book.order_of(goal).revoked_by)
            self._note_arrived(goal, gate.arrived.get(goal.id, 0))
            if goal.arrived >= goal.work.quantity:
                self._deliver(goal)
        for order in list(self._book.revoked()):
            self._shut(order)
        for product in dict.fromkeys(goal.work.product for goal in self._book):
            self._auctions.ask_next(product, now_s)

    def _is_held(self) -> bool:
        return self._auctions.awaits_answers

    # --- orders ---

    def _on_released(self, sender: str, message: OrderReleased, now_s: float) -> None:
        if self._shutdown.begun:
            # Unanswered, it is sent again, to the next life.
            self._out.append(Ignore("an order that came while the strategist was draining"))
            return
        if len(message.order) > ORDER_ID_MAX:
            self._out.append(Ignore("an order whose id leaves no room for those of its goals"))
            return
        if not all(self._book.can_be_made(item) for item in message.items):
            self._out.append(Ignore("an order for a product that nobody here makes"))
            return
        in_work = self._book.order(message.order)
        if in_work is not None and in_work.release < message.release:
            # It was never answered as taken back; what is outstanding of it nobody can know yet.
            self._out.append(Ignore("a release of an order that is in work"))
            return
        if not self._book.knows(message.order, message.release):
            if self._book.is_full:
                self._out.append(Ignore("an order that came while the strategist had as many as it takes"))
                return
            order = self._book.take(message)
            self._out.append(Record(OrderAccepted(order=order.id, goals=tuple(order.goals))))
            for item in message.items:
                self._auctions.ask_next(item.product, now_s)
            self._end_if_done(order)
        taken = OrderTaken(message.order, message.release, fulfilled=self._book.fulfilled(message.order))
        self._out.append(Send(sender, taken))

    def _on_cancelled(self, sender: str, message: OrderCancelled, now_s: float) -> None:
        """Drop an order, and say so as often as it is asked for, also of one that has not come yet."""
        order = self._book.close_order(message.order)
        if order is not None:
            self._drop(order, now_s)
        self._out.append(Send(sender, CancellationTaken(order=message.order)))

    def _drop(self, order: OrderInWork, now_s: float) -> None:
        for goal in order.goals.values():
            if goal.machine:
                # From now on the gate is shut for it, as for any goal that nobody is to make.
                self._out.append(Instruct(Admit(goal=goal.id, quantity=0)))
            self._end(goal, "withdrawn")
        for goal in order.goals.values():
            self._auctions.ask_next(goal.work.product, now_s)
        self._out.append(Record(OrderDropped(order=order.id)))

    def _on_revoked(self, sender: str, message: OrderRevoked, now_s: float) -> None:
        """Take an order back, and answer when the gate is shut for all of it, as often as it is asked for."""
        order = self._book.order(message.order)
        if order is None:
            self._answer_revoked(sender, message)
        elif message.release != order.release:
            self._out.append(Ignore("another release of an order was taken back"))
        elif not order.revoked_by:
            self._book.revoke(order, sender)
            self._shut(order)
            for item in order.items:
                self._auctions.ask_next(item.product, now_s)

    def _answer_revoked(self, asker: str, message: OrderRevoked) -> None:
        """Say again how an order was taken back; one that has not come will not be begun."""
        outstanding: tuple[int, ...] = ()
        returned = self._book.returned(message.order)
        if not self._book.knows(message.order, message.release):
            self._book.give_back(message.order, message.release)
        elif returned is not None and returned.release == message.release:
            outstanding = returned.outstanding
        self._out.append(Send(asker, RevocationTaken(message.order, message.release, outstanding)))

    def _shut(self, order: OrderInWork) -> None:
        """Withdraw what nobody makes yet, and shut the gate for the rest, whose last count is awaited."""
        for goal in list(order.goals.values()):
            if goal.machine:
                goal.failure = goal.failure or Reason.WITHDRAWN
                self._out.append(Instruct(Admit(goal=goal.id, quantity=0)))
            else:
                self._end(goal, "withdrawn")
                self._book.withdraw(goal)
        self._end_if_done(order)

    def _take_out(self, goal: OpenGoal) -> None:
        """The gate is shut and has counted: a goal of an order that was taken back is over."""
        self._end(goal, "withdrawn")
        order = self._book.withdraw(goal)
        withdrawn = GoalWithdrawn(goal=goal.id, machine=goal.machine, arrived=goal.arrived)
        self._out.append(Record(withdrawn))
        self._end_if_done(order)

    def _end_if_done(self, order: OrderInWork) -> None:
        if order.goals:
            return
        if any(order.withdrawn):
            returned = self._book.give_back(order.id, order.release)
            self._out.append(Record(OrderReturned(order.id, order.release, returned.outstanding)))
        else:
            self._book.close_order(order.id, fulfilled=True)
            self._out.append(Record(OrderFulfilled(order=order.id)))
        if order.revoked_by:
            taken = RevocationTaken(order.id, order.release, tuple(order.withdrawn))
            self._out.append(Send(order.revoked_by, taken))

    def _was_deaf(self, span_s: float) -> None:
        self._monitor.excuse(span_s)
        for goal in self._book:
            goal.named_s += span_s

    # --- goals that were given out ---

    def _follow(self, goal: OpenGoal, now_s: float, *, admit: bool = True) -> None:
        goal.named_s = now_s
        if admit:
            self._out.append(Instruct(Admit(goal=goal.id, quantity=goal.work.quantity)))
        self._timers.set((GOAL_CHECK, goal.id), now_s + GOAL_SILENCE_S)

    def _on_machine(self, _sender: str, heartbeat: MachineHeartbeat, now_s: float) -> None:
        machine = heartbeat.machine
        if not self._monitor.on_heartbeat(heartbeat, now_s):
            self._out.append(Ignore("an old heartbeat"))
            return
        for brief in heartbeat.goals:
            goal = self._book.goal(brief.goal)
            if goal is None:
                # It has not heard that its goal is closed, or was away when others got it.
                self._auctions.say_over(machine, brief)
            elif goal.machine == machine:
                goal.named_s = now_s
                if goal.offered is not (brief.offered is True):
                    goal.offered = not goal.offered
                    self._check_goal(goal.id, now_s)
                if brief.delivered > goal.arrived:
                    self._auctions.confirm(
                        goal
                    )  # It believes that pieces are in which the gate has not seen.
            elif goal.machine:
                self._auctions.withdraw(machine, goal.id, goal.epoch)

    def _on_arrived(self, report: GoodsArrived, now_s: float) -> None:
        goal = self._book.goal(report.goal)
        if goal is None:
            self._out.append(Ignore("goods of a goal that is closed"))
            return
        news = self._note_arrived(goal, report.arrived)
        if news and report.vehicle:
            goal.brought[report.vehicle] = goal.brought.get(report.vehicle, 0) + news
        if goal.arrived >= goal.work.quantity:
            self._deliver(goal)
        elif goal.failure and not report.admitted:
            if self._book.order_of(goal).revoked_by:
                self._take_out(goal)
                self._auctions.ask_next(goal.work.product, now_s)
            else:
                self._give_to_others(goal, now_s)
        elif news and goal.machine:
            self._auctions.confirm(goal)  # Its carrier waits for that word.

    def _note_arrived(self, goal: OpenGoal, arrived: int) -> int:
        """Tell what has arrived; returns how many pieces are news."""
        news = arrived - goal.arrived
        if news <= 0:
            return 0
        self._book.count(goal, arrived)
        work = goal.work
        delivered = GoodsDelivered(
            goal=goal.id,
            order=work.order,
            item=work.item,
            product=work.product,
            quantity=news,
            delivered=arrived,
        )
        self._out.append(Record(delivered))
        return news

    def _deliver(self, goal: OpenGoal) -> None:
        self._out.append(Send(goal.machine, GoalClosed(goal=goal.id)))
        self._end(goal, "delivered")
        order = self._book.close(goal)
        self._end_if_done(order)

    def _end(self, goal: OpenGoal, outcome: Outcome) -> None:
        """Follow a goal no longer."""
        self._timers.clear((GOAL_CHECK, goal.id))
        self._auctions.close_goal(goal, outcome)

    # --- when a machine fails ---

    def _check_goal(self, goal_id: str, now_s: float) -> None:
        """See whether a goal is still made; if not, and somebody else could make it, shut the gate for it."""
        goal = self._book.goal(goal_id)
        if goal is None:
            return
        # Once the gate is shut there is no way back: an older answer of it must not be taken for the last.
        failure = goal.failure or self._failure(goal, now_s)
        if not failure:
            goal.waits = False
        elif goal.failure or self._monitor.anybody_fit(goal.work, now_s):
            goal.failure = failure
            # For the strategist's own body, each time the alarm comes until the gate has counted: no message on the bus.
            self._out.append(Instruct(Admit(goal=goal.id, quantity=0)))
        else:
            self._auctions.say_waits(goal, now_s)
        look_s = now_s if failure else goal.named_s
        self._timers.set((GOAL_CHECK, goal.id), look_s + GOAL_SILENCE_S)

    def _failure(self, goal: OpenGoal, now_s: float) -> Reason | None:
        """Why a goal is not made any more; None while it is."""
        if now_s >= goal.named_s + GOAL_SILENCE_S:
            return self._monitor.failure(goal.machine, now_s) or Reason.FORGOTTEN
        if self._monitor.is_broken_for_long(goal.machine, now_s):
            return Reason.BROKEN
        return (self._monitor.failure(goal.machine, now_s) or Reason.BROKEN) if goal.offered else None

    def _give_to_others(self, goal: OpenGoal, now_s: float) -> None:
        """The gate is shut and has counted: put up what has not arrived, under a name of its own."""
        self._end(goal, "withdrawn")
        successor = self._book.succeed(goal)
        lost = GoalLost(goal=goal.id, machine=goal.machine, arrived=goal.arrived, successor=successor.id)
        self._out.append(Record(lost))
        self._auctions.ask_next(goal.work.product, now_s)
