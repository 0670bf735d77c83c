"""The calls of one agent that needs a person: it asks operators on duty, and others if nobody comes.

An agent calls for itself, and once for each of its loads on board of a failed vehicle. A call is repeated while
help is needed, even if nobody is there, so that no call is lost. An operator who comes on duty hears it, and
managers see that nobody is there. The agent's next life calls anew, and the operator who had taken the last call
takes it again.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, isfinite
from typing import Any, Protocol

from msgspec.structs import replace

from dray.messages import (
    CallAnswer,
    CallAnswered,
    CallPlace,
    CallState,
    DutyStatus,
    HelpCall,
    Message,
    OperatorHeartbeat,
    Problem,
)
from dray.messages.fact import HelpCallEnded
from dray.messages.keys import Keys
from dray.messages.people.call import CALL_WAIT_MAX_S
from dray.plant import Plant
from dray.plant.people import people_from_s
from dray.protocol.calls.call_rules import ANSWER_S, LATE_S, SAY_EVERY_S, is_there_for, next_asked, rest_s
from dray.protocol.calls.call_state import TRANSITIONS
from dray.protocol.calls.on_duty import OnDuty
from dray.protocol.runtime.life import Change, Life
from dray.states import States

CALL = "call"
"""The alarm ``(CALL, goods)`` of an open call: its next message or step is due."""

END_SAID = 3
"""How often the end of a call is sent: an operator that misses all of it hears the call no more, and forgets it."""

TAKEN_BEFORE = "an answer to a call that another operator has taken"
NO_CALL = "an answer to a call that is over or unknown"
NO_PROMISE = "an answer that takes a call without a valid time"
NOT_ON_DUTY = "an answer to a call by an operator who is not on duty"


class Call:
    """An open call."""

    def __init__(
        self,
        name: str,
        goods: str,
        problem: Problem,
        reason: str,
        now_s: float,
        place_m: tuple[float, float] | None,
        place: CallPlace,
    ) -> None:
        self.name, self.goods, self.since_s = name, goods, now_s
        self.problem, self.reason, self.place_m, self.place = problem, reason, place_m, place
        # It rests before the first operator is asked.
        self.states = States("a call", TRANSITIONS, CallState.RESTING)
        self.said = False
        self.round = 1
        self.rounds = self.passes = self.turn = 0
        self.asked: tuple[str, ...] = ()
        self.until_s: float | None = None
        self.taken_by = ""
        self.turn_s = 0.0
        """When the present operator has taken it."""
        self.taken_s: float | None = None
        """When it was taken first."""
        self.spared: set[str] = set()
        """Operators not asked again in this pass."""
        self.cannot: set[str] = set()
        self.ever_asked: set[str] = set()


class EndedCall:
    """A call that has ended."""

    def __init__(self, told: HelpCall) -> None:
        self.told, self.said = told, 1


class Caller(Protocol):
    """An agent that may need a person."""

    id: str
    incarnation: int

    @property
    def place_m(self) -> tuple[float, float]:
        """Its position (x, y) in m."""

    @property
    def hears_all(self) -> bool:
        """Whether it hears all messages; with only its radio it does not."""


class PlaceCaller:
    """A machine or a station in the form that calls need: it stands at its place, and hears everything."""

    hears_all = True

    def __init__(self, plant: Plant, life: Life) -> None:
        self.id, self.incarnation, self._plant = life.agent, life.incarnation, plant

    @property
    def place_m(self) -> tuple[float, float]:
        return self._plant.position_of(self.id)


@dataclass(frozen=True, slots=True)
class NotComing(Change):
    """The operator who took the agent's own call has given it back or has gone: later promises are void.

    Attributes:
        since_s: when that operator took the call (plant clock).
    """

    since_s: float


class HelpCalls:
    """The calls of one agent: one for itself, and one for each of its loads. Attributes without goods mean its own.

    Args:
        caller: the agent.
        plant: its areas and stations.
        life: the agent's life; alarms are named `CALL`.

    Attributes:
        message_handlers, alarms: entries for the agent's tables.
    """

    def __init__(self, caller: Caller, plant: Plant, life: Life) -> None:
        self._caller, self._plant, self._life = caller, plant, life
        keys = Keys(plant.id)
        self._heartbeats, self._key = keys.all_operator_heartbeats, keys.call(caller.id)
        self._duty = OnDuty()
        self._listens = False
        self._calls: dict[str, Call] = {}
        """By goods: the open calls, at most one for each transport of the agent."""
        self._ended: dict[str, EndedCall] = {}
        """By goods: calls whose end is being sent."""
        self._opened = self._number = 0
        self.message_handlers: dict[type[Message], Callable[[str, Any, float], None]] = {
            OperatorHeartbeat: self._on_heartbeat,
            CallAnswered: self._on_answered,
        }
        self.alarms: dict[str, Callable[[Any, float], None]] = {CALL: self._wake}

    @property
    def is_open(self) -> bool:
        """Whether the agent's own call is open."""
        return "" in self._calls

    @property
    def taken_by(self) -> str:
        """The operator who comes; empty for none."""
        return self._calls[""].taken_by if self.is_open else ""

    @property
    def goods(self) -> tuple[str, ...]:
        """The goods with an open call."""
        return tuple(goods for goods in self._calls if goods)

    def comes_after_s(self, now_s: float) -> float:
        """Time until an operator can be asked (s): 0 if one is or should be on duty; else the rest by the working time."""
        if any(each.status is not DutyStatus.BREAK for each in self._there(now_s)):
            return 0.0
        return people_from_s(self._plant, *self._caller.place_m, now_s) - now_s

    def listen(self) -> None:
        """Subscribe to operators' heartbeats, at the begin of the agent's life."""
        if not self._listens:
            self._listens = True
            self._life.subscribe(self._heartbeats)

    def open(
        self,
        problem: Problem,
        reason: str,
        now_s: float,
        *,
        after_s: float = 0.0,
        goods: str = "",
        place_m: tuple[float, float] | None = None,
        place: CallPlace = CallPlace.PRESENT,
    ) -> None:
        """Open a call for help, or update an open one.

        Args:
            problem: the known facts about it.
            reason: in words.
            now_s: the present time.
            after_s: delay before the first operator is asked; the problem may pass by itself.
            goods: the transport whose goods wait; empty for the agent itself.
            place_m: the place (x, y) in m, if not the agent's.
            place: how well that place is known.
        """
        call = self._calls.get(goods)
        if call is not None:
            call.problem, call.reason, call.place_m, call.place = problem, reason, place_m, place
            return
        self._opened += 1
        name = f"{self._caller.id}-{self._caller.incarnation}-{self._opened}"
        self._calls[goods] = call = Call(name, goods, problem, reason, now_s, place_m, place)
        self._ended.pop(goods, None)
        if after_s > 0.0:
            self._life.alarm((CALL, goods), now_s + after_s)
        else:
            self._ask(call, now_s)

    def close(self, now_s: float, *, goods: str = "") -> None:
        """End a call; ignored if there is none."""
        call = self._calls.pop(goods, None)
        if call is None:
            return
        self._life.cancel((CALL, goods))
        if not call.said:
            return
        call.states.enter(CallState.ENDED)
        call.asked, call.until_s, taken_by = (), None, call.taken_by
        self._ended[goods] = EndedCall(self._say(call, now_s))
        self._life.alarm((CALL, goods), now_s + SAY_EVERY_S)
        fact = HelpCallEnded(
            call=call.name,
            problem=call.problem.kind,
            asked=len(call.ever_asked),
            rounds=call.rounds,
            taken=call.turn,
            waited_s=None if call.taken_s is None else call.taken_s - call.since_s,
            lasted_s=max(0.0, now_s - call.since_s),
            helped=bool(taken_by),
        )
        self._life.record(fact)

    # --- time passes -------------------------------------------------------------------------------

    def _wake(self, goods: str, now_s: float) -> None:
        call = self._calls.get(goods)
        if call is None:
            self._say_ended(goods, now_s)
        elif not call.said:
            self._ask(call, now_s)
        elif call.states.now is CallState.TAKEN:
            if self._has_gone(call.taken_by, now_s):
                self._is_not_coming(call, now_s)
            elif now_s >= _due_s(call) + LATE_S:
                self._ask_others(call, now_s)
            else:
                self._go_on(call, now_s)
        elif call.until_s is not None and now_s >= call.until_s:
            # Silence declines, or a rest is over.
            if call.states.now is CallState.RESTING:
                call.round, call.spared = 1, set(call.cannot)
            self._ask(call, now_s)
        else:
            self._go_on(call, now_s)

    def _say_ended(self, goods: str, now_s: float) -> None:
        ended = self._ended.get(goods)
        if ended is None:
            return
        ended.said += 1
        self._publish(ended.told, now_s)
        if ended.said < END_SAID:
            self._life.alarm((CALL, goods), now_s + SAY_EVERY_S)
        elif goods:
            # New goods get new calls, so nothing of old ones is kept.
            del self._ended[goods]

    # --- operators and their answers -------------------------------------------------------------------

    def _on_heartbeat(self, sender: str, heartbeat: OperatorHeartbeat, now_s: float) -> None:
        could_be_asked = self._duty.can_be_asked(sender, now_s)
        if not self._duty.note(heartbeat, now_s):
            self._life.ignore("a heartbeat that a newer one has overtaken")
            return
        for call in list(self._calls.values()):
            if call.said:
                self._note_presence(call, sender, heartbeat, now_s, comes=not could_be_asked)

    def _note_presence(
        self, call: Call, sender: str, heartbeat: OperatorHeartbeat, now_s: float, *, comes: bool
    ) -> None:
        if heartbeat.draining:
            self._declined(call, sender, CallAnswer.DECLINE, now_s)
        elif call.states.now is CallState.RESTING and comes and sender not in call.cannot:
            # An operator who comes on duty, or back from a break, is asked at once.
            call.round = 1
            call.spared.discard(sender)
            self._ask(call, now_s)

    def _on_answered(self, sender: str, answered: CallAnswered, now_s: float) -> None:
        call = next((each for each in self._calls.values() if each.name == answered.call), None)
        if call is None or not call.said:
            self._life.ignore(NO_CALL)
            for ended in self._ended.values():
                if ended.told.call == answered.call:
                    self._publish(ended.told, now_s)
        elif answered.answer is not CallAnswer.TAKE:
            self._declined(call, sender, answered.answer, now_s)
        elif call.taken_by not in ("", sender):
            self._life.ignore(TAKEN_BEFORE)
            self._go_on(call, now_s)
        elif not _can_be_promised(answered.wait_s):
            self._life.ignore(NO_PROMISE)
        elif self._has_gone(sender, now_s):
            self._life.ignore(NOT_ON_DUTY)
        else:
            self._taken(call, sender, answered.wait_s or 0.0, now_s)

    def _taken(self, call: Call, sender: str, wait_s: float, now_s: float) -> None:
        if call.taken_by != sender:
            call.states.enter(CallState.TAKEN)
            call.taken_by, call.asked = sender, ()
            call.turn += 1
            call.turn_s = now_s
            if call.taken_s is None:
                call.taken_s = now_s
        # Repeated promises are bounded.
        call.until_s = min(now_s + wait_s, call.turn_s + 2.0 * CALL_WAIT_MAX_S)
        self._go_on(call, now_s)

    def _declined(self, call: Call, sender: str, answer: CallAnswer, now_s: float) -> None:
        if answer is CallAnswer.CANNOT:
            call.cannot.add(sender)
        call.spared.add(sender)
        if call.taken_by == sender:
            self._is_not_coming(call, now_s)
        elif sender in call.asked:
            call.asked = tuple(each for each in call.asked if each != sender)
            if call.asked:
                self._go_on(call, now_s)
            else:
                self._ask(call, now_s)

    # --- asking ----------------------------------------------------------------------------------------

    def _is_not_coming(self, call: Call, now_s: float) -> None:
        """The operator has given the call back, or has gone: later promises are void."""
        if not call.goods:
            self._life.note(NotComing(call.turn_s))
            self._life.settle(now_s)
        self._ask_others(call, now_s)

    def _ask_others(self, call: Call, now_s: float) -> None:
        """The operator has given the call back, has gone, or does not come: ask others."""
        call.spared.add(call.taken_by)
        call.taken_by, call.round = "", 1
        self._ask(call, now_s)

    def _ask(self, call: Call, now_s: float) -> None:
        """Ask the next operators; rest if there are none."""
        call.spared.update(call.asked)
        if call.states.now is CallState.ASKING:
            call.round += 1
        call.round, call.asked = next_asked(
            self._there(now_s),
            self._plant,
            self._place_m(call),
            call.problem.kind,
            call.round,
            call.spared,
        )
        call.ever_asked.update(call.asked)
        call.rounds += 1
        if call.asked:
            _enter(call, CallState.ASKING)
            call.until_s = now_s + ANSWER_S
        else:
            call.passes += 1
            _enter(call, CallState.RESTING)
            call.until_s = now_s + rest_s(call.passes)
        self._go_on(call, now_s)

    def _there(self, now_s: float) -> list[OperatorHeartbeat]:
        """Operators on duty; an agent that cannot hear them uses the last known ones."""
        return self._duty.there(now_s if self._caller.hears_all else -inf)

    def _has_gone(self, operator: str, now_s: float) -> bool:
        return self._duty.has_gone(operator, now_s) and self._caller.hears_all

    def _go_on(self, call: Call, now_s: float) -> None:
        """Publish the call's state, and again after a while."""
        self._say(call, now_s)
        at_s = now_s + SAY_EVERY_S
        if call.states.now is not CallState.TAKEN and call.until_s is not None:
            at_s = min(at_s, call.until_s)
        self._life.alarm((CALL, call.goods), at_s)

    def _place_m(self, call: Call) -> tuple[float, float]:
        return self._caller.place_m if call.place_m is None else call.place_m

    def _say(self, call: Call, now_s: float) -> HelpCall:
        x_m, y_m = self._place_m(call)
        here = frozenset(self._plant.areas_at(x_m, y_m))
        call.said = True
        told = HelpCall(
            call=call.name,
            caller=self._caller.id,
            incarnation=self._caller.incarnation,
            number=0,
            at_s=now_s,
            state=call.states.now,
            since_s=call.since_s,
            problem=call.problem,
            reason=call.reason,
            x_m=x_m,
            y_m=y_m,
            place=call.place,
            round=call.round,
            asked=call.asked,
            until_s=call.until_s,
            taken_by=call.taken_by,
            turn=call.turn,
            on_duty=sum(is_there_for(each, here) for each in self._there(now_s)),
            goods=call.goods,
        )
        return self._publish(told, now_s)

    def _publish(self, told: HelpCall, now_s: float) -> HelpCall:
        self._number += 1
        said = replace(told, number=self._number, at_s=now_s)
        self._life.publish(self._key, said)
        return said


def _enter(call: Call, state: CallState) -> None:
    if call.states.now is not state:
        call.states.enter(state)


def _due_s(call: Call) -> float:
    return call.since_s if call.until_s is None else call.until_s


def _can_be_promised(wait_s: float | None) -> bool:
    return wait_s is not None and isfinite(wait_s) and 0.0 < wait_s <= CALL_WAIT_MAX_S
