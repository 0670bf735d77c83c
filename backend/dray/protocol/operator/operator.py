"""An operator on duty: it shows presence, receives calls, and carries the person's answers.

The agent decides nothing for the person. It keeps what a person would forget: one call at a time, promises, and
calls that are over or were taken by another operator. Its body is the person with a tablet (`dray.body.DutyState`).
Without the tablet the operator stays on duty for a while. An operator who has promised to come is expected until
then: a tablet sleeps in a pocket.
"""

from __future__ import annotations

from dray.body import BodyState, CallPart, CallReplied, DutyChanged, DutyState, ShowCalls, ShownCall
from dray.errors import ProtocolViolation
from dray.memory import Memory
from dray.messages import (
    CallAnswer,
    CallAnswered,
    CallState,
    DutyStatus,
    HelpCall,
    OperatorHeartbeat,
)
from dray.messages.keys import Keys
from dray.messages.overtaken import LatestNumbers
from dray.protocol.liveness.suspicion import IDLE_INTERVAL_S
from dray.protocol.operator.commitment import Commitment
from dray.protocol.runtime.agent import AgentBase
from dray.protocol.runtime.bounded_map import BoundedMap
from dray.protocol.runtime.life import BEAT

LINGER_S = 30.0
"""Time on duty without the tablet (s): enough to reload a page, start a gateway, or cross a dead spot."""

LEAVES_WITHIN_S = 1.0
"""Nothing delays an operator who goes off duty."""

CALLS_MAX = 64
"""Maximum known calls: more than there are in one plant."""

CALL_SILENCE_S = 60.0
"""Silence after which a call counts as ended (s): it is repeated every few seconds."""

ANSWERED_MAX = 64
"""Maximum remembered declined calls."""

LOOK, GONE = "look", "gone"
"""Alarms: a call has expired or its answer is due; the tablet has been away for long enough."""

OVERTAKEN = "a call that a newer message has overtaken"
OVER = "an answer to a call that is over or unknown"
BUSY_ELSEWHERE = "an answer that takes a call while another one is taken"


class Operator(AgentBase):
    """One person on duty.

    Args:
        operator: its id on the bus; it begins with `OPERATOR_PREFIX`.
        plant: the plant's id.
        incarnation: rises each time that this person goes on duty.
    """

    def __init__(self, operator: str, plant: str, *, incarnation: int = 1) -> None:
        super().__init__(operator, incarnation, leaves_within_s=LEAVES_WITHIN_S)
        self._keys = Keys(plant)
        self._duty = DutyState()
        self._lingers_until_s = 0.0
        """End of the time without the tablet (s)."""
        self._calls: BoundedMap[tuple[str, str], tuple[HelpCall, float]] = BoundedMap(CALLS_MAX)
        """By subject: the newest message, and when it was heard."""
        self._newest: LatestNumbers[tuple[str, str]] = LatestNumbers(CALLS_MAX)
        self._declined: BoundedMap[str, bool] = BoundedMap(ANSWERED_MAX)
        """Calls that the person has declined or given back, and whether the caller has yet to hear that."""
        self._commitment = Commitment()
        self._shown: tuple[ShownCall, ...] = ()
        self._message_handlers = {HelpCall: self._on_call}
        self._report_handlers = {DutyChanged: self._duty_changed, CallReplied: self._call_replied}
        self._alarm_handlers = {BEAT: self._beat, LOOK: self._look, GONE: self._tablet_gone}

    @property
    def taken(self) -> tuple[str, int] | None:
        """The call whose caller expects this operator, and its turn; None for none."""
        return self._commitment.confirmed

    # --- the beginning, time passing, and the end ------------------------------------------------------

    def _start(self, body: BodyState | None, memory: Memory, now_s: float) -> None:
        self._life.subscribe(self._keys.all_calls)
        self._sense(body, now_s)
        self._life.beat_soon(now_s)

    def _sense(self, body: BodyState | None, now_s: float) -> None:
        if not isinstance(body, DutyState):
            raise ProtocolViolation(f"{self.id}: an operator needs a person's tablet, not {body!r}")
        if body == self._duty:
            return
        was_there, self._duty = self._duty.there, body
        if body.there:
            self._life.cancel(GONE)
        elif was_there:
            self._lingers_until_s = now_s + LINGER_S
            self._life.alarm(GONE, self._lingers_until_s)
        self._life.beat_soon(now_s)

    def _duty_changed(self, report: DutyChanged, now_s: float) -> None:
        self._sense(report.state, now_s)

    def _tablet_gone(self, _about: None, now_s: float) -> None:
        taken = self._commitment
        if taken.confirmed and taken.until_s is not None and now_s < taken.until_s:
            self._life.alarm(GONE, taken.until_s)
        else:
            self._on_leaving(now_s)

    def _beat(self, _about: None, now_s: float) -> None:
        self._say_status(now_s)
        self._life.beat_again(IDLE_INTERVAL_S, now_s)

    def _say_status(self, now_s: float) -> None:
        duty, taken = self._duty, self._commitment
        busy = bool(taken.call) or (duty.busy_until_s is not None and now_s < duty.busy_until_s)
        heartbeat = OperatorHeartbeat(
            operator=self.id,
            incarnation=self.incarnation,
            seq=self._life.count_beat(),
            at_s=now_s,
            status=DutyStatus.BUSY if busy else DutyStatus.BREAK if duty.on_break else DutyStatus.FREE,
            areas=duty.areas,
            everywhere=duty.everywhere,
            station=duty.station,
            helps_with=duty.helps_with,
            caller=taken.caller,
            until_s=taken.until_s if taken.call else duty.busy_until_s if busy else None,
            label=duty.label,
            draining=self._shutdown.begun,
        )
        self._life.publish(self._keys.operator_heartbeat(self.id), heartbeat)

    def _prepare_to_leave(self, now_s: float) -> None:
        if self._commitment.call:
            self._give_back(CallAnswer.DECLINE)
        self._show(())

    def _take_leave(self, now_s: float) -> None:
        self._say_status(now_s)

    # --- calls -----------------------------------------------------------------------------------------

    def _on_call(self, _sender: str, call: HelpCall, now_s: float) -> None:
        if not self._newest.takes(call.subject, (call.incarnation, call.number), now_s):
            self._life.ignore(OVERTAKEN)
            return
        self._calls.pop(call.subject, None)
        self._calls[call.subject] = call, now_s
        if call.call in self._declined and self.id not in (*call.asked, call.taken_by):
            self._declined[call.call] = False
        taken = self._commitment
        if call.taken_by == self.id and call.state is CallState.TAKEN:
            self._expected(call, now_s)
        elif taken.call == call.call and taken.loses(call):
            self._let_go(now_s)
        elif taken.call and taken.call != call.call and taken.subject == call.subject:
            # The caller was restarted and asks anew: the promise holds.
            self._renew(call, now_s)
        self._look(None, now_s)

    def _expected(self, call: HelpCall, now_s: float) -> None:
        """The caller expects this operator."""
        taken = self._commitment
        free = not taken.call or taken.subject == call.subject
        if not free or call.call in self._declined:
            self._answer(call.call, call.caller, CallAnswer.DECLINE)
            return
        was = taken.call, taken.until_s
        taken.confirm(call, now_s)
        if (taken.call, taken.until_s) != was:
            self._life.beat_soon(now_s)

    def _renew(self, call: HelpCall, now_s: float) -> None:
        wait_s = (self._commitment.until_s or now_s) - now_s
        self._let_go(now_s)
        if call.state is not CallState.ENDED and not call.taken_by and wait_s > 0.0:
            self._take(call, wait_s, now_s)

    def _look(self, _about: None, now_s: float) -> None:
        """Forget ended calls, repeat unconfirmed answers, and show the operator's calls."""
        for subject in [
            subject
            for subject, (call, heard_s) in self._calls.items()
            if call.state is CallState.ENDED or now_s >= heard_s + CALL_SILENCE_S
        ]:
            call = self._calls[subject][0]
            if self._commitment.call == call.call:
                self._let_go(now_s)
            if call.state is not CallState.ENDED:
                del self._calls[subject]
        taken = self._commitment
        if taken.waits and now_s >= taken.again_s:
            if now_s >= taken.give_up_s and taken.confirmed:
                taken.settle()
            elif now_s >= taken.give_up_s:
                self._give_back(CallAnswer.DECLINE)
                self._life.beat_soon(now_s)
            else:
                self._say_taken(now_s)
        self._show(tuple(shown for call, _ in self._calls.values() if (shown := self._shown_as(call))))
        silent_s = [
            heard_s + CALL_SILENCE_S
            for call, heard_s in self._calls.values()
            if call.state is not CallState.ENDED
        ]
        due_s = [*silent_s, *((taken.again_s,) if taken.waits else ())]
        if due_s:
            self._life.alarm(LOOK, min(due_s))
        else:
            self._life.cancel(LOOK)

    def _shown_as(self, call: HelpCall) -> ShownCall | None:
        taken = self._commitment
        if call.state is CallState.ENDED:
            return None
        if taken.call == call.call:
            return ShownCall(call, CallPart.TAKING if taken.waits else CallPart.TAKEN)
        if self.id in call.asked and not self._declined.get(call.call, False):
            return ShownCall(call, CallPart.ASKED)
        return None

    def _show(self, shown: tuple[ShownCall, ...]) -> None:
        if shown != self._shown:
            self._shown = shown
            self._life.instruct(ShowCalls(shown))

    # --- the person's answers --------------------------------------------------------------------------

    def _call_replied(self, report: CallReplied, now_s: float) -> None:
        call = next((call for call, _ in self._calls.values() if call.call == report.call), None)
        taken = self._commitment
        if call is None or call.state is CallState.ENDED or self._shutdown.begun:
            self._life.ignore(OVER)
        elif report.answer is CallAnswer.TAKE:
            if taken.call not in ("", call.call):
                self._life.ignore(BUSY_ELSEWHERE)
            elif call.taken_by not in ("", self.id):
                self._life.ignore(OVER)
            else:
                self._declined.pop(call.call, None)
                self._take(call, report.wait_s or 0.0, now_s)
        elif taken.call == call.call:
            self._give_back(report.answer)
            self._life.beat_soon(now_s)
        else:
            self._declined[call.call] = True
            self._answer(call.call, call.caller, report.answer)
        self._look(None, now_s)

    def _take(self, call: HelpCall, wait_s: float, now_s: float) -> None:
        self._commitment.take(call, now_s + wait_s, now_s)
        self._say_taken(now_s)
        self._life.beat_soon(now_s)

    def _say_taken(self, now_s: float) -> None:
        taken = self._commitment
        taken.said(now_s)
        wait_s = max((taken.until_s or now_s) - now_s, 1.0)
        self._answer(taken.call, taken.caller, CallAnswer.TAKE, wait_s)

    def _give_back(self, answer: CallAnswer) -> None:
        taken = self._commitment
        self._declined[taken.call] = True
        self._answer(taken.call, taken.caller, answer)
        taken.clear()

    def _let_go(self, now_s: float) -> None:
        self._commitment.clear()
        if not self._duty.there:
            self._life.alarm(GONE, max(now_s, self._lingers_until_s))
        self._life.beat_soon(now_s)

    def _answer(self, call: str, caller: str, answer: CallAnswer, wait_s: float | None = None) -> None:
        said = CallAnswered(call=call, operator=self.id, answer=answer, wait_s=wait_s)
        self._life.send(caller, said)
