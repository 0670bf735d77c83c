"""The duties of operators, and a simulated person on duty: the agent that runs in service, with the person as its body."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from contextlib import suppress
from enum import IntEnum
from math import inf

from dray.body import CallPart, CallReplied, DutyChanged, DutyState, Instruction, Report, ShowCalls, ShownCall
from dray.messages import OPERATOR_PREFIX, CallAnswer, HelpCall
from dray.messages.keys import Keys
from dray.messages.people.call import CALL_WAIT_MAX_S
from dray.plant.working_time import WorkingTime
from dray.ports import Bus, Clock
from dray.protocol.operator.operator import Operator as OperatorAgent
from dray.worker.worker import Worker
from dray_sim.factory.journal import HeldJournal


class Duty(IntEnum):
    """The possible duties of an operator, the most urgent first."""

    HELP = 0
    """A vehicle has a problem."""
    RELEASE = 1
    """A vehicle still stands because of an own stop."""
    FETCH = 2
    """A machine calls for its goods, which a vehicle has on board that has failed."""
    RECOVER = 3
    """A vehicle is silent."""
    SPEED_UP = 4
    """A vehicle has driven slowly for long enough."""
    RECONNECT = 5
    """A vehicle has delivered, and is left with its radio (paper, 4.3)."""


OWN = frozenset({Duty.RELEASE, Duty.SPEED_UP})
"""Duties that finish something that the operator has begun, in any area."""


CALLED = frozenset({Duty.HELP, Duty.RECONNECT})
"""Duties for which vehicles call."""


CONFIRMED_S = 20.0
"""Longer than the agent tries to have a call confirmed: then it has said how it went."""

TOO_SOON_S = 0.001


class PersonOnDuty:
    """One person's duty. It implements `dray.ports.Body`.

    Args:
        name: of the person; the agent's name on the bus follows from it.
        areas: the person's areas; None for all.
        keys: the plant's.
        bus: joined while on duty.
        clock: the plant's clock.
        looks_after: called with a call; if it returns False, the person answers at once that another one has to come.
        hours: the person's working time; work that has begun before a rest is finished in it.

    Attributes:
        agent_id: the agent's name on the bus.
        answered: calls that the person has answered, with the last answer: no person has taken a call without one.
    """

    def __init__(
        self,
        name: str,
        areas: tuple[str, ...] | None,
        *,
        keys: Keys,
        bus: Bus,
        clock: Clock,
        looks_after: Callable[[HelpCall], bool],
        hours: WorkingTime,
    ) -> None:
        self.agent_id = OPERATOR_PREFIX + name
        self.answered: dict[str, CallAnswer] = {}
        self._subjects: set[tuple[str, str]] = set()
        self._state = DutyState(areas=areas or (), everywhere=areas is None)
        self._keys, self._bus, self._clock = keys, bus, clock
        self._looks_after, self._hours = looks_after, hours
        self._journal = HeldJournal(incarnation=0)
        self._report: Callable[[Report], None] | None = None
        self._worker: Worker | None = None
        self._shown: dict[tuple[str, str], ShownCall] = {}
        self._changed = asyncio.Event()
        self._wanted = asyncio.Event()
        self._wanted.set()

    async def run(self) -> None:
        """Be on duty at the hours of the area, whenever the person wants to, until cancelled."""
        if self._hours.is_always:
            await self._be_on_duty()
            return
        async with asyncio.TaskGroup() as group:
            group.create_task(self._keep_hours())
            group.create_task(self._be_on_duty())

    @property
    def is_at_work(self) -> bool:
        """Whether these are the hours of the area."""
        return self._hours.is_on(self._clock.now_s())

    async def _keep_hours(self) -> None:
        while True:
            now_s = self._clock.now_s()
            if self._hours.is_on(now_s):
                self.come()
            else:
                self.go()
            change_s = self._hours.next_change_s(now_s)
            if change_s == inf:
                return
            # A sleep may end by its last bits too soon.
            await asyncio.sleep(max(change_s - now_s, TOO_SOON_S))

    async def _be_on_duty(self) -> None:
        while True:
            await self._wanted.wait()
            self._journal.begin_life()
            agent = OperatorAgent(self.agent_id, self._keys.plant, incarnation=self._journal.incarnation)
            self._worker = Worker(
                agent, bus=self._bus, clock=self._clock, keys=self._keys, body=self, journal=self._journal
            )
            await self._worker.run()
            self._worker = None
            self._show({})
            # A person who goes on duty again at once does so a moment later.
            await asyncio.sleep(1.0)

    @property
    def agent(self) -> OperatorAgent | None:
        """The running agent; None while off duty."""
        if self._worker is None or not isinstance(self._worker.agent, OperatorAgent):
            return None
        return self._worker.agent

    def go(self) -> None:
        """Go off duty."""
        self._wanted.clear()
        if self._worker is not None:
            self._worker.leave()

    def come(self) -> None:
        """Come on duty."""
        self._wanted.set()

    def lose_tablet(self) -> None:
        """The tablet is lost, or its battery is empty: no agent is told so."""
        self._change(there=False)
        self._wanted.clear()

    def have_tablet(self) -> None:
        """Another tablet, or another battery."""
        self._change(there=True)
        self._wanted.set()

    def shown(self, caller: str, goods: str = "") -> ShownCall | None:
        """The call of this agent, or for goods of its own, that is shown to the person; None for none."""
        return self._shown.get((caller, goods))

    @property
    def calls(self) -> tuple[ShownCall, ...]:
        """All that concern the person."""
        return tuple(self._shown.values())

    def has_taken(self, subject: tuple[str, str]) -> bool:
        """Whether the person has ever taken a call about this (`HelpCall.subject`)."""
        return subject in self._subjects

    async def take(self, call: HelpCall, wait_s: float) -> bool:
        """Take a call; True when its caller has confirmed it."""
        self._subjects.add(call.subject)
        self.reply(call.call, CallAnswer.TAKE, max(1.0, min(wait_s, CALL_WAIT_MAX_S)))
        end_s = self._clock.now_s() + CONFIRMED_S
        while True:
            shown = self._shown.get(call.subject)
            if shown is None or shown.call.call != call.call or shown.part is CallPart.ASKED:
                return False
            if shown.part is CallPart.TAKEN:
                return True
            self._changed.clear()
            with suppress(TimeoutError):
                await asyncio.wait_for(self._changed.wait(), max(end_s - self._clock.now_s(), 0.0))
            if self._clock.now_s() >= end_s:
                return False

    async def walk_to(self, caller: str, walk_s: float, look_s: float, goods: str = "") -> None:
        """Be on the way to somebody, and say so when asked meanwhile.

        Args:
            caller: to whom.
            walk_s: how long it takes.
            look_s: how often the person looks at the tablet.
            goods: for which goods of that one.
        """
        there_s = self._clock.now_s() + walk_s
        while (left_s := there_s - self._clock.now_s()) > 0.0:
            await asyncio.sleep(min(look_s, left_s))
            shown = self.shown(caller, goods)
            if shown is not None and shown.part is CallPart.ASKED:
                await self.take(shown.call, max(left_s, look_s))

    def reply(self, call: str, answer: CallAnswer, wait_s: float | None = None) -> None:
        """Touch a button of a call."""
        self.answered[call] = answer
        if self._report is not None and self._worker is not None:
            self._report(CallReplied(call=call, answer=answer, wait_s=wait_s))

    # --- dray.ports.Body -------------------------------------------------------------------------------

    def instruct(self, instruction: Instruction) -> None:
        """See `dray.ports.Body`."""
        if isinstance(instruction, ShowCalls):
            self._show({shown.call.subject: shown for shown in instruction.calls})

    def sense(self) -> DutyState:
        """See `dray.ports.Body`."""
        return self._state

    def attach(self, report: Callable[[Report], None]) -> None:
        """See `dray.ports.Body`."""
        self._report = report

    def _show(self, shown: dict[tuple[str, str], ShownCall]) -> None:
        self._shown = shown
        self._changed.set()
        for each in shown.values():
            if each.part is CallPart.ASKED and not self._looks_after(each.call):
                asyncio.get_running_loop().call_soon(self.reply, each.call.call, CallAnswer.CANNOT)

    def _change(self, *, there: bool) -> None:
        state = self._state
        self._state = DutyState(there=there, areas=state.areas, everywhere=state.everywhere)
        if self._report is not None and self._worker is not None:
            self._report(DutyChanged(self._state))
