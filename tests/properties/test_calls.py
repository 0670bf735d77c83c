"""Calls for help on any network: one taker each, nobody assigned, nobody with two calls, and no call lost."""

from __future__ import annotations

from random import Random

import hypothesis.strategies as st
from callers import CallerRig, OperatorRig
from hypothesis import settings
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from dray.body import CallPart, DutyChanged, ShowCalls
from dray.messages import CallAnswer, CallState, HelpCall, Message
from dray.protocol.runtime.events import Effect, Instruct, Publish, Send

CALLERS = ("ATV1", "ATV2")
OPERATORS = ("operator.A", "operator.B", "operator.C")

SETTLE_S = 400.0
"""A promise that nobody keeps, its lateness, and the longest rest."""

Letter = tuple[str, str, Message]
"""From whom, to whom (empty for everybody), and what."""


class Calling(RuleBasedStateMachine):
    """Two that call, three on duty, and words that are lost, doubled and overtaken."""

    @initialize()
    def begin(self) -> None:
        self.now_s = 0.0
        self.callers = {name: CallerRig(name) for name in CALLERS}
        self.operators = {name: OperatorRig(name) for name in OPERATORS}
        self.under_way: list[Letter] = []
        self.said: set[tuple[str, str]] = set()
        """Who has ever said to take a call of whom."""
        self.had: dict[tuple[str, int], str] = {}
        self.newest: dict[str, HelpCall] = {}
        self.taken_s: dict[str, float] = {}
        """Call -> when it was said last that somebody has taken it."""
        self.shown: dict[str, dict[str, CallPart]] = {}
        for name, rig in (*self.callers.items(), *self.operators.items()):
            self.post(name, rig.start())

    def post(self, sender: str, effects: list[Effect]) -> None:
        for effect in effects:
            if isinstance(effect, Publish):
                self.under_way.append((sender, "", effect.message))
                self.check(sender, effect.message)
            elif isinstance(effect, Instruct) and isinstance(effect.instruction, ShowCalls):
                self.shown[sender] = {each.call.call: each.part for each in effect.instruction.calls}
            elif isinstance(effect, Send):
                self.under_way.append((sender, effect.to, effect.message))

    def check(self, caller: str, said: Message) -> None:
        """A turn has one taker, who has said so."""
        if isinstance(said, HelpCall):
            self.newest[caller] = said
            if said.state is CallState.TAKEN:
                self.taken_s[said.call] = self.now_s
            if said.state is CallState.TAKEN:
                assert self.had.setdefault((said.call, said.turn), said.taken_by) == said.taken_by
                assert (said.taken_by, caller) in self.said, f"{said.taken_by} was assigned {said.call}"

    def deliver(self, letter: Letter) -> None:
        sender, to, message = letter
        for name, rig in (*self.callers.items(), *self.operators.items()):
            if to in ("", name) and name != sender:
                rig.now_s = max(rig.now_s, self.now_s)
                self.post(name, rig.on_message(sender, message))

    @rule(caller=st.sampled_from(CALLERS))
    def someone_calls(self, caller: str) -> None:
        self.post(caller, self.callers[caller].open())

    @rule(caller=st.sampled_from(CALLERS))
    def help_is_over(self, caller: str) -> None:
        self.post(caller, self.callers[caller].close())

    @rule(caller=st.sampled_from(CALLERS))
    def a_caller_is_started_again(self, caller: str) -> None:
        rig = self.callers[caller]
        again = CallerRig(caller, rig.agent.incarnation + 1)
        again.now_s = self.now_s
        calls = rig.agent.calls.is_open
        self.callers[caller] = again
        self.post(caller, again.start())
        if calls:
            self.post(caller, again.open())

    @rule(
        operator=st.sampled_from(OPERATORS),
        caller=st.sampled_from(CALLERS),
        answer=st.sampled_from(CallAnswer),
        wait_s=st.sampled_from([5.0, 60.0, 300.0]),
    )
    def a_person_answers(self, operator: str, caller: str, answer: CallAnswer, wait_s: float) -> None:
        rig = self.operators[operator]
        known = rig.agent._calls.get(caller)
        if known is not None:
            if answer is CallAnswer.TAKE:
                self.said.add((operator, caller))
            self.post(operator, rig.replies(known[0], answer, wait_s))

    @rule(operator=st.sampled_from(OPERATORS), there=st.booleans())
    def a_tablet_is_lost_or_found(self, operator: str, there: bool) -> None:
        rig = self.operators[operator]
        if rig.has_left:
            again = OperatorRig(operator, rig.agent.incarnation + 1)
            again.now_s = self.now_s
            self.operators[operator] = again
            self.post(operator, again.start())
        elif rig.state.there is not there:
            rig.state = type(rig.state)(there=there, areas=rig.state.areas)
            self.post(operator, rig.report(DutyChanged(rig.state)))

    @rule(chance=st.randoms(use_true_random=False), loss_frac=st.sampled_from([0.0, 0.3, 1.0]))
    def words_arrive_somehow(self, chance: Random, loss_frac: float) -> None:
        letters, self.under_way = self.under_way, []
        chance.shuffle(letters)
        for letter in letters:
            if chance.random() >= loss_frac:
                self.deliver(letter)
                if chance.random() < 0.2:
                    self.under_way.append(letter)

    @rule(span_s=st.sampled_from([0.5, 3.0, 10.0, 40.0]))
    def time_passes(self, span_s: float) -> None:
        self.now_s += span_s
        for name, rig in (*self.callers.items(), *self.operators.items()):
            if not (isinstance(rig, OperatorRig) and rig.has_left):
                self.post(name, rig.run(self.now_s))

    @invariant()
    def nobody_shares_a_turn_and_nobody_has_two_calls(self) -> None:
        if not hasattr(self, "had"):
            return
        turns = [rig.agent.taken for rig in self.operators.values() if rig.agent.taken and not rig.has_left]
        assert len(turns) == len(set(turns)), f"a call with two takers: {turns}"
        for shown in self.shown.values():
            assert len([part for part in shown.values() if part is not CallPart.ASKED]) <= 1

    def teardown(self) -> None:
        """From now on words arrive, and one is willing: every open call is taken by somebody."""
        if not hasattr(self, "had"):
            return
        for operator in OPERATORS:
            self.a_tablet_is_lost_or_found(operator, True)
        end_s = self.now_s + SETTLE_S
        while self.now_s < end_s:
            self.time_passes(3.0)
            letters, self.under_way = self.under_way, []
            for letter in letters:
                self.deliver(letter)
            for operator, rig in self.operators.items():
                for call, part in self.shown.get(operator, {}).items():
                    caller = call.split("-")[0]
                    if part is CallPart.ASKED and self.callers[caller].agent.calls.is_open:
                        self.said.add((operator, caller))
                        self.post(operator, rig.replies(call, CallAnswer.TAKE, 300.0))
                        break
            self.nobody_shares_a_turn_and_nobody_has_two_calls()
        for name, caller in self.callers.items():
            if caller.agent.calls.is_open:
                # Nobody keeps what was promised here, so a call may be between two that take it.
                call = self.newest[name].call
                assert self.taken_s.get(call, -1.0) >= end_s - SETTLE_S, f"{call} was lost"


Calling.TestCase.settings = settings(max_examples=8, stateful_step_count=30)
TestCalling = Calling.TestCase
