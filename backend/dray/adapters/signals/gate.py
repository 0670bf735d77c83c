"""The body of the delivery warehouses' gate with single-value signals of a controller: a counter, and the label that is read there.

    who        does                                      signal
    controller reads the label of a container            goal
    agent      says how many of its pieces may come in   admitted_goal, admitted
    controller lets at most that many in, and counts     pieces
    controller has the container behind it               goal empty
    agent      takes the permit back                     admitted 0

Only then does the controller show the next label. So whatever is counted belongs to the goal of the last permit, also after a restart of the
agent or a broken connection: only the agent gives permits. A new permit waits until a label has been shown for `SETTLE_S`, because a count
may arrive after the label that followed it. A permit ends likewise: what it has not brought `SETTLE_S` after its label went does not come.
A permit that is taken back while its label is shown ends that long after the controller has confirmed it; by MQTT nothing is confirmed.

`admitted` is the number of pieces from the beginning of the permit on. It does not fall while they come in: the controller compares it with
what it has let in itself, so that it makes no difference how late the agent hears the counts.

A count that no permit explains is in doubt. The gate stays shut until people have counted (`Checked`). Until then no goal is reported as shut:
more of it may be in than is counted.

A permit that the controller refuses holds up its own container only. It is given again after `AGAIN`, then after twice that time, and so on.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Protocol

from msgspec import Struct
from msgspec.structs import replace

from dray.adapters.signals.counting import CounterState, Reading, count_pulse, doubt_of_another, grown
from dray.adapters.signals.signal import (
    Quality,
    Sample,
    Signal,
    SignalMapping,
    Value,
    brief,
    fault_words,
    quoted,
)
from dray.body import Admit, GateProblem, GateState, GoodsArrived, Instruction, Report
from dray.messages.base import COUNT_MAX
from dray.ports import Clock, nobody_hears

KEPT_GOALS = 4096
"""Maximum goals remembered, as by any gate: a finished one is remembered for hours."""

SETTLE_S = 1.0
"""Real seconds for which a label must have been shown before its pieces may come in. A count comes at most this late."""

AGAIN, AGAIN_MOST = 5, 300
"""Shortest and longest wait before a refused permit is given again, in units of the gate's `settle_s`: seconds."""

NEEDED = (Signal.PIECES, Signal.GOAL, Signal.FAULT)
"""Signals without whose value the gate is shut."""


class SignalledGoal(Struct, frozen=True, omit_defaults=True):
    """One goal at the gate."""

    admitted: int
    arrived: int = 0


class KeptSignals(Struct, frozen=True):
    """The gate's memory for the agent's next life."""

    goals: dict[str, SignalledGoal] = {}
    """Goals, the longest unchanged first."""
    pieces: CounterState | None = None
    permit: str = ""
    """The goal of the last permit."""
    left: int = 0
    """Pieces that the last permit may still bring in."""
    doubt_number: int = 0
    """The number of the last doubt: the plant's time at which it began (s). So no number repeats, even when the memory was lost."""
    doubt: str = ""
    """Why counts may be wrong, until people have counted; empty for none."""


DAMAGED_SIGNALS = KeptSignals(doubt="what was remembered of it is damaged")
"""The memory after unreadable data."""


class _Refusal(Struct, frozen=True):
    """A permit that the controller has refused."""

    signal: Signal
    label: str
    admitted: int
    reason: str
    times: int
    """Refusals of this label, one after the other."""
    until_s: float
    """The same permit is not given before (plant's clock)."""


class World(Protocol):
    """The surroundings of the body, beside its clock."""

    def remember(self, kept: KeptSignals) -> None:
        """Store the memory: on the disk at the return."""

    def write(self) -> None:
        """The body's `outputs` have changed: send them to the controller."""


def settle_s(speed: float) -> float:
    """The time for which a label must have been shown, at this speed of the plant's clock."""
    return SETTLE_S * max(1.0, speed)


class SignalledGate:
    """Implements `dray.ports.Body` and the listener of a link.

    Args:
        mapping: its controller's signals.
        clock: the plant's.
        world: the disk and the link.
        kept: the last life's memory; None for the first one.
        settle_s: the time for which a label must have been shown.
        kept_goals: maximum goals remembered.
        broker: the address of its controller's broker; empty by OPC UA.

    Attributes:
        outputs: the wanted outputs, by signal; a link writes the differences.
        away: why the gate is shut: its controller is away, has a fault or no values, or its count is in doubt; empty while it works.
        away_since_s: since when; None while it works.
        held: why the container that stands there is not let in though it may; empty if nothing is wrong with its permit.
        problem: the last reported one: that of `away` or `held`, without labels.
    """

    def __init__(
        self,
        mapping: SignalMapping,
        clock: Clock,
        world: World,
        kept: KeptSignals | None = None,
        *,
        settle_s: float = SETTLE_S,
        kept_goals: int = KEPT_GOALS,
        broker: str = "",
    ) -> None:
        self._broker = broker
        self._mapping, self._tags, self._clock, self._world = mapping, mapping.signals, clock, world
        self._settle_s, self._most = settle_s, kept_goals
        self._kept = kept or KeptSignals()
        self._report: Callable[[Report], None] = nobody_hears
        self._moduli: tuple[int, ...] = ()
        if (end := self._tags[Signal.PIECES].rolls_over_at) is not None:
            self._moduli = (end,)
        self._link = "nothing was heard of its controller yet"
        self._gap = True
        """Whether values may have been missed since the last count."""
        self._silent: dict[Signal, str] = {}
        self._refused: dict[Signal, str] = {}
        """Why the present value of an output is refused."""
        self._refusal: _Refusal | None = None
        self._fault = self._fault_text = ""
        self._seen: str | None = None
        """The label, empty for none; None while it is unknown."""
        self._is_over, self._settled, self._turn = False, False, 0
        """Whether the container of the last permit is gone; whether a permit may be given; the number of the last wait for that, so that an
        outdated call of the clock is recognised."""
        self._may_permit = not broker
        """Whether the controller may have a permit that the agent has taken back: it has not confirmed the end yet. By MQTT it never does."""
        self._base: int | None = None
        """Pieces of the goal that were in when the present permit began; None without a permit."""
        self.away = self.problem = self._link
        self.away_since_s: float | None = clock.now_s()
        self.outputs: dict[str, Value] = {Signal.ADMITTED: 0, Signal.ADMITTED_GOAL: self._kept.permit}
        checked = mapping.checked
        if self._kept.doubt and not self._kept.doubt_number:
            self._keep(self._doubted(self._kept, self._kept.doubt))
        if self._kept.doubt and checked is not None and checked.doubt == self._kept.doubt_number:
            kept = replace(self._kept, doubt="")
            for goal, arrived in checked.arrived.items():
                known = kept.goals.get(goal, SignalledGoal(0))
                kept = self._with(kept, goal, replace(known, arrived=max(known.arrived, arrived)))
            self._keep(kept)
        self._judge()

    @property
    def label(self) -> str:
        """The label that is read there; empty for none."""
        return self._seen or ""

    # --- Body ---

    def instruct(self, instruction: Instruction) -> None:
        """See `dray.ports.Body`. Other instructions are ignored: no report would fit them."""
        if not isinstance(instruction, Admit):
            return
        before = self._kept.goals.get(instruction.goal)
        goal = replace(before or SignalledGoal(0), admitted=instruction.quantity)
        if goal != before:
            self._keep(self._with(self._kept, instruction.goal, goal))
        self._permit()
        self._say(instruction.goal)

    def sense(self) -> GateState:
        """See `dray.ports.Body`."""
        arrived = {name: goal.arrived for name, goal in self._kept.goals.items()}
        return GateState(arrived=arrived, late=True, problem=self.problem)

    def attach(self, report: Callable[[Report], None]) -> None:
        """See `dray.ports.Body`."""
        self._report = report

    # --- the listener of a link ---

    def on_link(self) -> None:
        """The controller is connected, and its values come. It is told first that no permit is left from before."""
        self._link = ""
        self._wait()
        self._judge()

    def on_link_lost(self, reason: str) -> None:
        """The controller is away: nothing may come in, and its label is outdated."""
        self._link, self._gap = f"its controller is not heard: {reason}", True
        self._may_permit = not self._broker
        self._silent.clear()
        self._see(None)
        self._judge()

    def on_range(self, signal: str, moduli: tuple[int, ...]) -> None:
        """The controller has sent where its counter may roll over; the mapping takes precedence."""
        if self._tags[Signal(signal)].rolls_over_at is None:
            self._moduli = moduli

    def on_sample(self, name: str, sample: Sample) -> None:
        """The controller has sent a value."""
        signal = Signal(name)
        value = sample.value if sample.quality is Quality.GOOD else None
        if value is None:
            reason: str | None = sample.reason or f"it is {sample.quality.value}"
        else:
            reason = self._take(signal, value)
        if reason is None:
            self._silent.pop(signal, None)
        else:
            self._silent[signal] = brief(reason)
            if signal is Signal.GOAL:
                self._see(None)
            elif signal is Signal.PIECES:
                self._gap = True
        self._judge()

    def on_refused(self, name: str, reason: str) -> None:
        """The controller refuses a value; without a reason it accepts it again."""
        signal, admitted = Signal(name), int(self.outputs[Signal.ADMITTED])
        if reason:
            self._refused[signal] = brief(reason)
            if admitted and signal in (Signal.ADMITTED, Signal.ADMITTED_GOAL):
                self._bar(signal, admitted, self._refused[signal])
        else:
            self._refused.pop(signal, None)
            if admitted and self._refusal is not None and self._refusal.signal is signal:
                self._refusal = None
        self._judge()

    def on_written(self, name: str, value: Value) -> None:
        """The controller has confirmed a value: an `admitted` of 0 has ended its permit, and the last counts are on their way."""
        if name == Signal.ADMITTED and value == self.outputs[Signal.ADMITTED] == 0 and self._may_permit:
            self._may_permit = False
            if self._is_exceeded(self._kept.permit):
                self._wait()

    # --- values ---

    def _take(self, signal: Signal, value: Value) -> str | None:
        """Process a value; returns why that is impossible, None otherwise."""
        tag = self._tags[signal]
        match signal:
            case Signal.PIECES:
                return self._take_count(value)
            case Signal.GOAL:
                if not isinstance(value, str):
                    return f"{quoted(value)} is no label"
                self._see(value.strip())
            case Signal.FAULT:
                self._fault = brief(fault_words(value, inverted=tag.invert))
            case Signal.FAULT_TEXT:
                self._fault_text = brief(str(value))
            case _:
                return "the controller is told this, and does not tell it"
        return None

    def _take_count(self, value: Value) -> str | None:
        number = self._number(value)
        if isinstance(number, str):
            return number
        edge = self._tags[Signal.PIECES].edge
        last, gap, self._gap = self._kept.pieces, self._gap, False
        left, source = self._kept.left, self._mapping.source(Signal.PIECES, self._moduli)
        now = CounterState(number, self._clock.now_s(), source, self._broker)
        if last is None:
            reading = Reading()
        elif another := doubt_of_another(last, now, "let in"):
            # Another counter at a shut gate has missed nothing.
            reading = Reading(0, another if left else "")
        elif edge is not None:
            # With a shut gate nothing can have come in unheard.
            reading = count_pulse(bool(last.value), bool(number), edge, gap=gap and left > 0)
            if reading.pieces > left:
                reading = Reading(0, "showed a piece that was not admitted")
        else:
            # A counter that is reset at a shut gate has lost nothing.
            reading = grown(last.value, number, left, self._moduli, gap=gap and left > 0, verb="let in")
        if last is not None and replace(last, at_s=now.at_s) == now and not reading.doubt:
            return None
        kept = replace(self._kept, pieces=now)
        if reading.doubt and not kept.doubt:
            kept = self._doubted(kept, f"{Signal.PIECES} {reading.doubt}")
        if not reading.pieces:
            self._keep(kept)
            return None
        name = kept.permit
        goal = kept.goals.get(name, SignalledGoal(0))
        goal = replace(goal, arrived=min(goal.arrived + reading.pieces, COUNT_MAX))
        self._keep(replace(self._with(kept, name, goal), left=left - reading.pieces))
        self._say(name)
        self._permit()
        return None

    def _number(self, value: Value) -> int | str:
        """What the counter shows, or 1 or 0 for a pulse; else why it is neither."""
        tag = self._tags[Signal.PIECES]
        if tag.edge is not None:
            return int(value) if isinstance(value, bool) else f"{quoted(value)} is no pulse"
        if isinstance(value, bool | str) or not math.isfinite(value):
            return f"{quoted(value)} is no count"
        number = round(value / tag.scale)
        if number < 0 and self._moduli:
            number %= max(self._moduli)  # A signed counter continues below 0.
        return number if number >= 0 else f"{quoted(value)} is no count"

    # --- permits ---

    def _see(self, label: str | None) -> None:
        """A label is shown; empty for none, None while it is unknown."""
        if label == self._seen:
            return
        self._seen, self._is_over = label, True
        self._wait()
        self._permit()

    def _wait(self) -> None:
        """Give no permit until counts that are on their way have come."""
        self._settled = False
        self._turn += 1
        self._clock.call_at(self._clock.now_s() + self._settle_s, partial(self._settle, self._turn))

    def _settle(self, turn: int) -> None:
        if turn != self._turn or self._seen is None:
            return
        permit, is_exceeded = self._kept.permit, self._is_exceeded(self._kept.permit)
        is_there = is_exceeded and self._seen == permit
        if self._gap or (is_there and self._may_permit) or (is_exceeded and self.away and not self._is_over):
            # The count of what came in meanwhile is still to come, or the controller may not have taken the end of the permit.
            self._wait()
            return
        if self._kept.left and (self._is_over or is_exceeded):
            # What the last permit has not brought by now does not come any more.
            self._keep(replace(self._kept, left=0))
            if is_exceeded:
                self._say(permit)
        self._is_over, self._settled = False, True
        self._permit()

    def _permit(self) -> None:
        """Tell the controller how many pieces of the shown label may come in."""
        label = self._seen or ""
        goal, admitted = self._kept.goals.get(label), 0
        if goal is not None and self._settled and not self.away:
            room = goal.admitted - goal.arrived
            base = goal.arrived if self._base is None else self._base
            admitted = max(0, goal.admitted - base)
            if self._is_barred(label, admitted):
                admitted = 0
            elif admitted:
                if room > 0 and (self._kept.permit != label or room > self._kept.left):
                    # On the disk first: what comes in belongs to this goal.
                    self._keep(replace(self._kept, permit=label, left=room))
                self._base = base
        if self._base is not None and not admitted:
            # The controller counts anew from the next permit on. What this one has brought must be known by then.
            self._base = None
            self._wait()
        permit = self._kept.permit
        if not admitted and self._refusal is not None and self._refusal.label == permit:
            permit = ""  # It may be the label that is refused.
        outputs: dict[str, Value] = {Signal.ADMITTED: admitted, Signal.ADMITTED_GOAL: permit}
        if outputs != self.outputs:
            self.outputs = outputs
            self._may_permit |= admitted > 0 and not self._broker
            self._world.write()
        self._tell()

    def _say(self, name: str) -> None:
        """Report the count of a goal, and how many pieces may be in: more than are admitted until a permit for more has ended.

        While the count is in doubt it is final for no goal: a shut one is reported as if it could still get a piece.
        """
        goal = self._kept.goals[name]
        most = goal.arrived + self._kept.left if self._is_exceeded(name) else goal.admitted
        if self._kept.doubt:
            most = max(most, 1)
        self._report(GoodsArrived(name, goal.arrived, most))

    def _is_exceeded(self, name: str) -> bool:
        """Whether the last permit may bring in more pieces of a goal than are admitted now."""
        goal, left = self._kept.goals.get(name), self._kept.left
        return goal is not None and name == self._kept.permit and left > max(0, goal.admitted - goal.arrived)

    def _bar(self, signal: Signal, admitted: int, reason: str) -> None:
        """Give the present permit again after a while: longer after each refusal."""
        label, before = str(self.outputs[Signal.ADMITTED_GOAL]), self._refusal
        times = before.times + 1 if before is not None and before.label == label else 1
        until_s = self._clock.now_s() + self._settle_s * min(AGAIN * 2 ** min(times - 1, 16), AGAIN_MOST)
        self._refusal = _Refusal(signal, label, admitted, reason, times, until_s)
        self._clock.call_at(until_s, self._permit)

    def _is_barred(self, label: str, admitted: int) -> bool:
        refusal = self._refusal
        return (
            refusal is not None
            and (refusal.label, refusal.admitted) == (label, admitted)
            and self._clock.now_s() < refusal.until_s
        )

    @property
    def held(self) -> str:
        """See the class."""
        refusal = self._refusal
        if refusal is None or refusal.label != self._seen:
            return ""
        return f"its controller refuses a permit for {refusal.admitted} of {refusal.label} ({refusal.signal}): {refusal.reason}"

    def _tell(self) -> None:
        """Report a changed problem. Labels are left out: they name orders, which not everybody sees who sees the gate."""
        problem, refusal = self._problem(), self._refusal
        if not problem and refusal is not None and self.held:
            problem = f"its controller refuses a permit ({refusal.signal}): {refusal.reason}"
        if problem != self.problem:
            self.problem = problem
            self._report(GateProblem(problem))

    def _judge(self) -> None:
        """Shut the gate while anything is wrong."""
        away = self._problem()
        if self._kept.doubt and self._kept.permit and away == self._doubt():
            away += f"; the last permit was for {self._kept.permit}"
        if away and not self.away:
            self.away_since_s = self._clock.now_s()
        self.away = away
        if not away:
            self.away_since_s = None
        self._permit()

    def _problem(self) -> str:
        if self._link:
            return self._link
        if self._fault:
            return f"its controller has a fault: {self._fault_text or self._fault}"
        for signal in NEEDED:
            if signal in self._silent:
                return f"its controller has no value for {signal}: {self._silent[signal]}"
        for signal, is_missing in ((Signal.PIECES, self._gap), (Signal.GOAL, self._seen is None)):
            if is_missing:
                return f"its controller has no value for {signal}: nothing was said yet"
        for refused, reason in self._refused.items():
            return f"its controller does not take {refused}: {reason}"
        if self._kept.doubt:
            return self._doubt()
        return ""

    def _doubt(self) -> str:
        return f"its count is in doubt ({self._kept.doubt_number}): {self._kept.doubt}"

    # --- memory ---

    def _doubted(self, kept: KeptSignals, doubt: str) -> KeptSignals:
        """The memory with a new doubt."""
        number = max(kept.doubt_number + 1, int(self._clock.now_s()))
        return replace(kept, doubt=doubt, doubt_number=number)

    def _with(self, kept: KeptSignals, name: str, goal: SignalledGoal) -> KeptSignals:
        """The memory with a changed goal as its last one; above the limit a finished one is forgotten first."""
        goals = {each: known for each, known in kept.goals.items() if each != name} | {name: goal}
        if len(goals) > self._most:
            finished = (each for each, known in goals.items() if known.arrived >= known.admitted)
            del goals[next(finished, next(iter(goals)))]
        return replace(kept, goals=goals)

    def _keep(self, kept: KeptSignals) -> None:
        """Remember something. On the disk first: nothing may follow from what the next life would not know."""
        self._world.remember(kept)
        self._kept = kept
