"""A strategist with a gate in a separate agent: instructions to the gate and its answers become messages.

`Strategist` works as if it had the gate as its body. Here its instructions become messages, repeated until they are
answered, and answers become reports. A machine's goal is confirmed only after the gate admits it. A life begins
when the gate has reported the orders that it holds; before that it does nothing, and machines go on without it. A
shut goal or an ended order is stored until the gate has acknowledged it: no order of the next life would repeat it.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from msgspec.structs import replace

from dray.body import Admit, GateState, GoodsArrived, HoldOrder
from dray.memory import ShutWord
from dray.messages import (
    AdmissionAsked,
    Confirmed,
    CountAcknowledged,
    GateAsked,
    GateReported,
    GoodsCounted,
    HolderAcknowledged,
    HolderReported,
    Message,
    OrderClaimed,
    OrderReleased,
    StationHeartbeat,
)
from dray.messages.gate import GoalOf
from dray.messages.keys import GATE, Keys
from dray.messages.overtaken import LatestNumber, LatestNumbers
from dray.plant import Plant
from dray.protocol.runtime.bounded_map import BoundedMap
from dray.protocol.runtime.events import (
    Commit,
    Effect,
    Event,
    Ignore,
    Instruct,
    Received,
    Reported,
    Send,
    Started,
)
from dray.protocol.runtime.retransmission import Retransmitter
from dray.protocol.strategist.order_book import ORDERS_MAX
from dray.protocol.strategist.order_holding import GOAL_NAME
from dray.protocol.strategist.strategist import Strategist

WORD = "word to the gate"
"""Alarm of a repeated message to the gate, with its subject."""

ASKED = "what is held"
"""Subject of the question with which a life begins."""

GOALS_KEPT = 4096
"""Maximum goals with counts by vehicle: as many as the gate knows."""

OLD = "an outdated message of the gate"


class GatedStrategist(Strategist):
    """One plant's strategist with a gate in another agent.

    Args:
        plant: the plant with its machines and products.
        gate: the id of the gate's agent.
        options: see `Strategist`.
    """

    def __init__(self, plant: Plant, *, gate: str = GATE, **options: Any) -> None:
        super().__init__(plant, **options)
        self._gate = gate
        self._gate_key = Keys(plant.id).station_heartbeat(gate)
        self._shares = bool(options.get("others"))
        self._started: Started | None = None
        """The start event, until the gate has reported what is held."""
        self._held_then: dict[str, int] = {}
        """Held orders reported so far, with their epochs."""
        self._begun = False
        self._early: BoundedMap[str, Received] = BoundedMap(ORDERS_MAX)
        """By order: releases received before the start; this strategist must know them even if another one takes them."""
        self._gate_newest = LatestNumber((0, 0), 0.0)
        """The gate's newest heartbeat, by life and number."""
        self._gate_since = 0
        self._words = Retransmitter(WORD, self._life)
        self._alarm_handlers = {**self._alarm_handlers, WORD: self._words.wake}
        self._number = 0
        self._asked: dict[str, AdmissionAsked] = {}
        """The last unanswered message about each goal."""
        self._unconfirmed: dict[str, None] = {}
        """Those goals whose machines wait for a confirmation."""
        self._claimed: dict[str, OrderClaimed] = {}
        """By order: the unanswered claim."""
        self._noted: dict[str, ShutWord] = {}
        """Stored messages that the next life has to send, by the name of their note."""
        self._brought: BoundedMap[str, dict[str, int]] = BoundedMap(GOALS_KEPT)
        self._epochs: LatestNumbers[str] = LatestNumbers(ORDERS_MAX)
        """The newest report of each order's holder, by epoch."""

    def handle(self, event: Event, now_s: float) -> list[Effect]:
        """See `dray.protocol.runtime.events.Agent`."""
        if isinstance(event, Started):
            self._started = event
            self._life.subscribe(self._gate_key)
            self._ask(now_s)
            return self._taken_out()
        if isinstance(event, Received):
            if event.sender == self._gate:
                effects = self._on_gate(event.message, now_s)
                if effects is not None:
                    return effects
            if not self._begun:
                if isinstance(event.message, OrderReleased):
                    self._early[event.message.order] = event
                return [Ignore("a message from before the gate's first one")]
        return self._step(event, now_s)

    def _step(self, event: Event, now_s: float) -> list[Effect]:
        """Take one step of the strategist, and send its instructions to the gate."""
        effects: list[Effect] = []
        for effect in super().handle(event, now_s):
            if isinstance(effect, Instruct):
                effects += self._say(effect.instruction, now_s)
            else:
                effects.append(effect)
        return [effect for effect in effects if not self._is_early(effect)]

    def _is_early(self, effect: Effect) -> bool:
        """Whether a confirmation comes before the gate's admission: the machine is told after the gate's answer."""
        if not isinstance(effect, Send) or not isinstance(effect.message, Confirmed):
            return False
        asked = self._asked.get(effect.message.task)
        is_early = asked is not None and asked.quantity > 0
        if is_early:
            self._unconfirmed[effect.message.task] = None
        return is_early

    def _taken_out(self) -> list[Effect]:
        """Effects made outside of a step."""
        effects = list(self._life.effects)
        self._life.effects.clear()
        return effects

    # --- the beginning ---

    def _ask(self, now_s: float, after: str = "") -> None:
        begins = self._started
        forgotten = begins is not None and not self._shares and not begins.memory
        self._words.say(ASKED, Send(self._gate, GateAsked(forgotten, after)), now_s)

    def _on_reported(self, told: GateReported, now_s: float) -> list[Effect]:
        if ASKED not in self._words:
            return [Ignore(OLD)]
        since, self._gate_since = self._gate_since, told.since
        if self._started is None:
            self._words.settle(ASKED)
            return self._say_all(now_s) if since != told.since else []
        self._held_then.update({each.order: each.epoch for each in told.held})
        if told.more:
            self._ask(now_s, told.held[-1].order)
            return self._taken_out()
        self._words.settle(ASKED)
        started, self._started, self._begun = self._started, None, True
        self._noted = {name: note for name, note in started.memory.items() if isinstance(note, ShutWord)}
        unsaid = list(self._noted.values())
        memory = {name: note for name, note in started.memory.items() if name not in self._noted}
        effects = self._step(Started(GateState({}, self._held_then), memory, started.lost), now_s)
        for note in unsaid:
            if note.goal and note.goal not in self._asked:
                effects += self._say(Admit(note.goal, 0), now_s)
            elif note.order and note.order not in self._claimed:
                effects += self._say(HoldOrder(note.order, note.epoch, note.over), now_s)
        for heard in self._early.values():
            effects += self._step(heard, now_s)
        self._early.clear()
        return effects

    def _say_all(self, now_s: float) -> list[Effect]:
        """The gate has lost its notes: repeat what it has to know."""
        effects: list[Effect] = []
        for order in self._book.orders():
            if self._shares and self._book.held_with(order.id):
                effects += self._say(HoldOrder(order.id, self._book.held_with(order.id)), now_s)
        for goal in self._book:
            if goal.machine and not goal.work.part_of:
                of = GoalOf(goal.work.order, goal.work.item, goal.machine, goal.epoch)
                quantity = 0 if goal.failure else goal.work.quantity
                effects += self._say(Admit(goal.id, quantity, of if self._shares else None), now_s)
        return effects

    # --- messages to the gate ---

    def _say(self, instruction: object, now_s: float) -> list[Effect]:
        if isinstance(instruction, Admit):
            return self._say_admitted(instruction, now_s)
        assert isinstance(instruction, HoldOrder)  # noqa: S101 - a strategist instructs nothing else
        order = instruction.order
        before = self._claimed.get(order)
        # An end that the gate has not heard of yet is not forgotten.
        over = 0 if before is None or instruction.again else before.over
        said = OrderClaimed(order, instruction.epoch, max(instruction.over, over), instruction.again)
        self._claimed[order] = said
        self._words.say(f"order {order}", Send(self._gate, said), now_s)
        note = ShutWord(order=order, epoch=said.epoch, over=said.over) if said.over else None
        return [*self._noting(f"{order} over", note), *self._taken_out()]

    def _say_admitted(self, admit: Admit, now_s: float) -> list[Effect]:
        goal, before = admit.goal, self._asked.get(admit.goal)
        held = self._book.held_with(GOAL_NAME.sub("", goal)) if self._shares else 0
        said = AdmissionAsked(goal, admit.quantity, self.incarnation, self._number + 1, admit.of, held)
        if before is not None and replace(said, number=before.number) == before:
            said = before
        else:
            self._number += 1
        self._asked[goal] = said
        self._words.say(f"goal {goal}", Send(self._gate, said), now_s)
        note = None if admit.quantity else ShutWord(goal=goal)
        return [*self._noting(f"{goal} shut", note), *self._taken_out()]

    def _noting(self, name: str, note: ShutWord | None) -> Iterator[Effect]:
        """Store what the next life has to send, or delete it."""
        if note == self._noted.get(name):
            return
        if note is None:
            del self._noted[name]
        else:
            self._noted[name] = note
        yield Commit(note, name)

    # --- messages from the gate ---

    def _on_gate(self, message: Message, now_s: float) -> list[Effect] | None:
        """The effects of a gate's message; None for one that is not used here."""
        if isinstance(message, GateReported):
            return self._on_reported(message, now_s)
        if isinstance(message, StationHeartbeat):
            return self._on_heartbeat(message, now_s)
        if not self._begun:
            return None
        if isinstance(message, GoodsCounted):
            return self._on_counted(message, now_s)
        if isinstance(message, HolderReported):
            return self._on_holder(message, now_s)
        return None

    def _on_heartbeat(self, heartbeat: StationHeartbeat, now_s: float) -> list[Effect]:
        """Detect a restart of the gate, which may have lost its orders."""
        life, _ = self._gate_newest.number
        if self._gate_newest.takes((heartbeat.incarnation, heartbeat.seq), now_s):
            if self._begun and life not in (0, heartbeat.incarnation) and not self._shutdown.begun:
                self._ask(now_s)
        return self._taken_out()

    def _on_counted(self, counted: GoodsCounted, now_s: float) -> list[Effect]:
        goal, effects = counted.goal, list[Effect]()
        asked = self._asked.get(goal)
        if asked is not None:
            if (counted.incarnation, counted.number) != (asked.incarnation, asked.number):
                # The answer includes what has arrived by then.
                return [Ignore(OLD)]
            del self._asked[goal]
            self._words.settle(f"goal {goal}")
            effects += self._noting(f"{goal} shut", None)
        if counted.arrived:
            effects.append(Send(self._gate, CountAcknowledged(goal, counted.arrived)))
        for report in self._reports(counted):
            effects += self._step(Reported(report), now_s)
        if goal in self._unconfirmed and goal not in self._asked:
            del self._unconfirmed[goal]
            open_goal = self._book.goal(goal)
            if open_goal is not None and open_goal.machine:
                self._auctions.confirm(open_goal)
        return [*effects, *self._taken_out()]

    def _reports(self, counted: GoodsCounted) -> Iterator[GoodsArrived]:
        """The reports that a local gate would have made: one for each vehicle with new pieces."""
        goal, known = counted.goal, self._brought.get(counted.goal, {})
        total = counted.arrived - sum(each.pieces for each in counted.brought) + sum(known.values())
        for each in counted.brought:
            news = each.pieces - known.get(each.vehicle, 0)
            if news > 0:
                total += news
                # Only the last report may conclude a shut goal.
                yield GoodsArrived(
                    goal, total, max(1, counted.admitted), each.vehicle, by_people=counted.by_people
                )
        self._brought[goal] = {each.vehicle: each.pieces for each in counted.brought}
        yield GoodsArrived(goal, counted.arrived, counted.admitted, by_people=counted.by_people)

    def _on_holder(self, told: HolderReported, now_s: float) -> list[Effect]:
        held, effects = told.held, list[Effect]()
        order, is_ours = held.order, held.holder == self.id
        if not is_ours:
            effects.append(Send(self._gate, HolderAcknowledged(order, held.epoch)))
        if not self._epochs.stands(order, (held.epoch,), now_s):
            return [*effects, Ignore(OLD)]
        claimed = self._claimed.get(order)
        if claimed is not None and (
            (is_ours and held.over >= claimed.over and not 0 < claimed.again <= held.over)
            or (not is_ours and held.epoch >= claimed.epoch)
        ):
            del self._claimed[order]
            self._words.settle(f"order {order}")
            effects += self._noting(f"{order} over", None)
        if not is_ours:
            effects += self._forget_goals(order)
        return effects + self._step(Reported(held), now_s)

    def _forget_goals(self, order: str) -> list[Effect]:
        """Another strategist has taken over the goals of an order."""
        effects: list[Effect] = []
        for goal in [goal for goal in self._asked if GOAL_NAME.sub("", goal) == order]:
            del self._asked[goal]
            self._unconfirmed.pop(goal, None)
            self._words.settle(f"goal {goal}")
            effects += self._noting(f"{goal} shut", None)
        return effects
