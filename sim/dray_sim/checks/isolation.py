"""Invariants 6 and 7: the effects on other agents when one fails.

Like those of `dray_sim.checks.invariants`, these checks hear all messages, look at the running agents, and take no
part.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from dray.messages import (
    THING,
    AtvHeartbeat,
    AtvStatus,
    Event,
    MachineHeartbeat,
    Message,
    Phase,
    Role,
    StationHeartbeat,
    Transport,
)
from dray.messages.fact import (
    AtvStatusChanged,
    AwardAnswered,
    CarrierChanged,
    ContractEnded,
    ContractTaken,
    Fact,
    MemoryLost,
    PhaseEntered,
    TaskClosed,
    TaskOpened,
    TookOver,
)
from dray.protocol.liveness.suspicion import IDLE_INTERVAL_S, LATENESS_MAX_S, MISSES_MAX, WORKING_INTERVAL_S
from dray_sim.checks.broken import InvariantBroken
from dray_sim.factory.sim_factory import SimFactory

LOOK_S = 1.0
"""Interval between two looks at the running agents: a death is noticed at most so much later."""

DELAY_S = 6.0
"""Longest transit time of a dead agent's last heartbeat: the slowest link of the paper has 5 s."""

LATE_S = 1.0
"""A heartbeat is said at its interval, and no agent is busy for so long in between."""


class SpeaksOn:
    """Invariant 6: when one agent fails, every other agent goes on sending heartbeats."""

    def __init__(self, factory: SimFactory) -> None:
        self._factory = factory
        self._heard_s: dict[str, float] = {}
        self._lives: dict[str, int] = {}
        """Number of each agent's life, which shows an absence between two looks."""
        self._look_s = 0.0

    def on_message(self, at_s: float, sender: str, _address: str, message: Message) -> None:
        if isinstance(message, AtvHeartbeat | MachineHeartbeat | StationHeartbeat):
            self._heard_s[sender] = at_s
        if at_s >= self._look_s:
            if at_s > self._look_s + LOOK_S:
                # No agent has said anything, so it is unknown which were running: all begin anew.
                self._heard_s = dict.fromkeys(self._heard_s, at_s)
            self._look_s = at_s + LOOK_S
            self._look(at_s)

    def _look(self, at_s: float) -> None:
        factory, journals = self._factory, self._factory.journals
        for agent in (*factory.workcells, *factory.storages, *factory.vehicles):
            if agent not in self._heard_s:
                continue  # The factory may not run yet.
            life = journals[agent].incarnation
            if not factory.running(agent) or life != self._lives.get(agent, life):
                self._heard_s[agent] = at_s
            self._lives[agent] = life
            silent_s = at_s - self._heard_s[agent]
            if silent_s > IDLE_INTERVAL_S + LATE_S:
                raise InvariantBroken(6, at_s, f"{agent} runs and has said nothing for {silent_s:.1f} s")


@dataclass(slots=True)
class _Watch:
    """One secondary."""

    epoch: int
    since_s: float


@dataclass(slots=True)
class _Carried:
    """One open transport, as an observer knows it."""

    goods: bool
    coordinator: str
    primary: str = ""
    epoch: int = 0
    """Epoch of the present carrier. A secondary of an earlier one watches another vehicle."""
    loading: bool = False
    """The primary is at its source or past it."""
    watchers: dict[str, _Watch] = field(default_factory=dict)
    """Vehicles that are secondary by their own messages."""

    def assign(self, primary: str, epoch: int) -> None:
        """The task has a primary from now on."""
        self.primary, self.epoch, self.loading = primary, epoch, False


class ReplacedInTime:
    """Invariant 7: with a living secondary, a dead primary is replaced within the suspicion bound.

    The bound is that of the worst link that is still a link, from the arrival of the last heartbeat:

        DELAY_S + MISSES_MAX * WORKING_INTERVAL_S + LATENESS_MAX_S

    A good link makes it earlier, which is measured elsewhere; this check does not know the quality of links. There
    are two exceptions. A secondary that is stopped or in error cannot drive. Goods and things that may be on board of
    the dead vehicle cannot be fetched by another one.
    """

    BOUND_S = DELAY_S + MISSES_MAX * WORKING_INTERVAL_S + LATENESS_MAX_S

    def __init__(self, factory: SimFactory) -> None:
        self._factory = factory
        self._tasks: dict[str, _Carried] = {}
        self._dead_s: dict[str, float] = {}
        self._lives: dict[str, int] = {}
        """Watches are not remembered: they end with the life in which they were taken."""
        self._unfit: dict[str, None] = {}
        self._look_s = 0.0

    def on_message(self, at_s: float, sender: str, _address: str, message: Message) -> None:
        if type(message) is Event:
            self._note(message.fact, sender, at_s)
        if at_s >= self._look_s:
            self._look_s = at_s + LOOK_S
            self._look(at_s)

    def _note(self, fact: Fact, agent: str, at_s: float) -> None:
        if type(fact) is AtvStatusChanged:
            if fact.status in (AtvStatus.STOPPED, AtvStatus.ERROR):
                self._unfit[agent] = None
            else:
                self._unfit.pop(agent, None)
        elif type(fact) is TaskOpened:
            if type(fact.work) is Transport:
                self._tasks.setdefault(
                    fact.task, _Carried(bool(fact.work.goal) or fact.work.item == THING, agent)
                )
        elif type(fact) is MemoryLost:
            # A coordinator cannot reassign a task that it does not know.
            self._tasks = {
                task: carried for task, carried in self._tasks.items() if carried.coordinator != agent
            }
        elif isinstance(fact, TaskClosed):
            self._tasks.pop(fact.task, None)
        elif (task := self._tasks.get(getattr(fact, "task", ""))) is not None:
            self._note_task(task, fact, agent, at_s)

    def _note_task(self, task: _Carried, fact: Fact, agent: str, at_s: float) -> None:
        if type(fact) is AwardAnswered:
            if fact.role is Role.PRIMARY and fact.answer == "accepted":
                task.assign(fact.bidder, fact.epoch)
        elif type(fact) is CarrierChanged:
            task.assign(fact.carrier, fact.epoch)
        elif type(fact) is TookOver:
            task.assign(agent, fact.epoch)
            task.watchers.pop(agent, None)
        elif type(fact) is PhaseEntered:
            if agent == task.primary:
                task.loading = fact.phase is not Phase.APPROACHING
        elif isinstance(fact, ContractTaken) and fact.role is Role.SECONDARY:
            task.watchers[agent] = _Watch(fact.epoch, at_s)
        elif isinstance(fact, ContractEnded) and fact.role is Role.SECONDARY:
            task.watchers.pop(agent, None)

    def _look(self, at_s: float) -> None:
        running, journals = self._factory.running, self._factory.journals
        for atv in self._factory.vehicles:
            life = journals[atv].incarnation
            if life != self._lives.get(atv, life):
                for carried in self._tasks.values():
                    carried.watchers.pop(atv, None)
            self._lives[atv] = life
            if running(atv):
                self._dead_s.pop(atv, None)
            else:
                self._dead_s.setdefault(atv, at_s)
        for task, carried in self._tasks.items():
            for watcher in [each for each in carried.watchers if each in self._dead_s]:
                del carried.watchers[watcher]
            dead_s = self._dead_s.get(carried.primary)
            if dead_s is not None and not (carried.goods and carried.loading):
                self._check(task, carried, dead_s, at_s)

    def _check(self, task: str, carried: _Carried, dead_s: float, at_s: float) -> None:
        for watcher, watch in carried.watchers.items():
            if watcher in self._unfit:
                watch.since_s = at_s
            elif watch.epoch >= carried.epoch and at_s - max(dead_s, watch.since_s) > self.BOUND_S:
                seen = (
                    f"{carried.primary} is dead for {at_s - dead_s:.1f} s, and {watcher}, which watches it, "
                    f"has not taken {task} over"
                )
                raise InvariantBroken(7, at_s, seen)
