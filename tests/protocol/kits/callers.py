"""Somebody who calls for help, and operators with a tablet of paper."""

from __future__ import annotations

from defaults import PLANT
from rigs import Rig

from dray.body import BodyState, CallPart, CallReplied, DutyState, ShowCalls
from dray.memory import Memory
from dray.messages import (
    CallAnswer,
    CallAnswered,
    DutyStatus,
    HelpCall,
    OperatorHeartbeat,
    Problem,
    ProblemKind,
)
from dray.protocol.calls.help_calls import HelpCalls, NotComing
from dray.protocol.operator.operator import Operator
from dray.protocol.runtime.agent import AgentBase
from dray.protocol.runtime.events import Effect, Instruct, Publish

BLOCKED = Problem(kind=ProblemKind.WAY_BLOCKED, needs_person=True)

NORTH_M, SOUTH_M = (30.0, 30.0), (30.0, 2.0)
"""Places in the default plant, in AREA1 and elsewhere."""


class CallingAgent(AgentBase):
    """An agent that does nothing but call."""

    def __init__(self, agent: str, incarnation: int = 1) -> None:
        super().__init__(agent, incarnation, leaves_within_s=1.0)
        self.place_m = NORTH_M
        self.hears_all = True
        self.calls = HelpCalls(self, PLANT, self._life)
        self._message_handlers = self.calls.message_handlers
        self._alarm_handlers = self.calls.alarms
        self.void_since_s: list[float] = []
        """When the operators who do not come had taken the call."""
        self._reactions = {NotComing: lambda change, _now_s: self.void_since_s.append(change.since_s)}

    def _start(self, body: BodyState | None, memory: Memory, now_s: float) -> None:
        self.calls.listen()

    def flush(self) -> list[Effect]:
        """What was wanted outside of a step."""
        effects, self._life.effects[:] = list(self._life.effects), []
        return effects


class CallerRig(Rig):
    """One that calls."""

    agent: CallingAgent

    def __init__(self, agent: str = "ATV1", incarnation: int = 1) -> None:
        super().__init__(CallingAgent(agent, incarnation))
        self._beats: dict[str, int] = {}

    def open(self, problem: Problem = BLOCKED, *, after_s: float = 0.0) -> list[Effect]:
        self.agent.calls.open(problem, "a pallet", self.now_s, after_s=after_s)
        return self._flushed()

    def close(self) -> list[Effect]:
        self.agent.calls.close(self.now_s)
        return self._flushed()

    def _flushed(self) -> list[Effect]:
        effects = self.agent.flush()
        self.all += effects
        return effects

    def beats(
        self,
        operator: str,
        areas: tuple[str, ...] = ("AREA1",),
        status: DutyStatus = DutyStatus.FREE,
        *,
        draining: bool = False,
        station: str = "",
        helps_with: tuple[ProblemKind, ...] = (),
    ) -> list[Effect]:
        """An operator is there."""
        seq = self._beats[operator] = self._beats.get(operator, 0) + 1
        heartbeat = OperatorHeartbeat(
            operator=operator,
            incarnation=1,
            seq=seq,
            at_s=self.now_s,
            status=status,
            areas=areas,
            draining=draining,
            station=station,
            helps_with=helps_with,
        )
        return self.on_message(operator, heartbeat)

    def answers(
        self, operator: str, answer: CallAnswer, wait_s: float | None = None, call: str = ""
    ) -> list[Effect]:
        """An operator answers the newest call."""
        name = call or self.said.call
        return self.on_message(
            operator, CallAnswered(call=name, operator=operator, answer=answer, wait_s=wait_s)
        )

    def passes(self, span_s: float, *there: str) -> list[Effect]:
        """Time passes, and these go on being there."""
        effects: list[Effect] = []
        until_s = self.now_s + span_s
        while self.now_s < until_s:
            effects += self.run(min(until_s, self.now_s + 5.0))
            for operator in there:
                effects += self.beats(operator)
        return effects

    @property
    def said(self) -> HelpCall:
        """The newest word."""
        return said_of(self.all)[-1]


def said_of(effects: list[Effect]) -> list[HelpCall]:
    """All words on calls."""
    return [
        effect.message
        for effect in effects
        if isinstance(effect, Publish) and isinstance(effect.message, HelpCall)
    ]


class OperatorRig(Rig):
    """One on duty."""

    agent: Operator

    def __init__(self, operator: str = "operator.A", incarnation: int = 1) -> None:
        super().__init__(Operator(operator, PLANT.id, incarnation=incarnation))
        self.state = DutyState(areas=("AREA1",))

    def sense(self) -> DutyState:
        return self.state

    def replies(self, call: HelpCall | str, answer: CallAnswer, wait_s: float | None = None) -> list[Effect]:
        """The person touches a button."""
        name = call if isinstance(call, str) else call.call
        return self.report(CallReplied(call=name, answer=answer, wait_s=wait_s))

    @property
    def shown(self) -> dict[str, CallPart]:
        """What the tablet shows."""
        told = [
            effect.instruction
            for effect in self.all
            if isinstance(effect, Instruct) and isinstance(effect.instruction, ShowCalls)
        ]
        return {shown.call.call: shown.part for shown in told[-1].calls} if told else {}
