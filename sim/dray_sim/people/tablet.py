"""An operator's tablet: it shows the heartbeats of vehicles and machines, and repeats commands until they are answered."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TypedDict

from msgspec import UNSET

from dray.adapters.security.signing import SigningKey
from dray.messages import (
    AtvHeartbeat,
    CallState,
    CommandAnswered,
    CommandKind,
    HelpCall,
    MachineCommand,
    MachineCommandKind,
    MachineHeartbeat,
    Message,
    VehicleCommand,
)
from dray.messages.keys import Keys
from dray.ports import Bus, Clock, Session
from dray_sim.people.answers import Answers

ANSWER_S = 2.0
"""A vehicle answers within a network round trip; after this long a command is said again."""

TRIES = 15
"""Half a minute of saying it again; then the vehicle does not hear."""

GRANT_S = 60.0
"""Validity of a command: the time of its repetitions and of its transit."""


CALL_OLD_S = 15.0
"""A call is said every 5 s; one that was not heard for so long is not shown any more."""


@dataclass(frozen=True, slots=True)
class LastHeard:
    """A vehicle as the tablet shows it."""

    heartbeat: AtvHeartbeat
    at_s: float
    """When that was heard."""


class _Limits(TypedDict):
    """Limits of a grant; see `SigningKey.grant`."""

    person: str
    areas: tuple[str, ...] | None
    valid_until_s: float


class Tablet:
    """The tablet of one person.

    Args:
        person: its user, and its name on the bus.
        areas: in which that person's commands are granted; None for all.
        keys: the plant's.
        bus: joined while it is on.
        clock: the plant's clock.
        authority: grants the commands.

    Attributes:
        heard: the last heartbeat of every vehicle, in any area.
        machines: the same of every machine.
    """

    def __init__(
        self,
        person: str,
        areas: tuple[str, ...] | None,
        *,
        keys: Keys,
        bus: Bus,
        clock: Clock,
        authority: SigningKey,
    ) -> None:
        self.heard: dict[str, LastHeard] = {}
        self._calls: dict[tuple[str, str], tuple[HelpCall, float]] = {}
        """Newest call about a subject, and when it was heard."""
        self.machines: dict[str, MachineHeartbeat] = {}
        self._person = person
        self._areas = areas
        self._keys = keys
        self._bus = bus
        self._clock = clock
        self._authority = authority
        self._session: Session
        """Session since it was last switched on."""
        self._commands = 0
        self._answers = Answers()

    @contextmanager
    def on(self) -> Iterator[None]:
        """While this lasts, vehicles are heard and commands can be said."""
        self._session = self._bus.join(self._person, self._on_message)
        self._session.subscribe(self._keys.atv_heartbeat("*"))
        self._session.subscribe(self._keys.all_calls)
        self._session.subscribe(self._keys.all_machine_heartbeats)
        try:
            yield
        finally:
            self._session.leave()

    async def say(
        self,
        atv: str,
        kind: CommandKind,
        *,
        speed_frac: float | None = None,
        wait_s: float | None = None,
    ) -> CommandAnswered | None:
        """Repeat a command until it is answered; None without an answer."""
        self._commands += 1
        command = VehicleCommand(
            command=f"{self._person}-{self._commands}",
            kind=kind,
            speed_frac=speed_frac,
            wait_s=wait_s,
            issued_by=self._person,
        )
        return await self._give(atv, command.command, self._authority.grant(atv, command, **self._limits()))

    async def tell(
        self,
        machine: str,
        kind: MachineCommandKind,
        *,
        speed_frac: float | None = None,
        wait_s: float | None = None,
        reason: str = "",
        after_work: bool = False,
        task: str = "",
        node: str = "",
    ) -> CommandAnswered | None:
        """The same to a machine."""
        self._commands += 1
        command = MachineCommand(
            command=f"{self._person}-{self._commands}",
            kind=kind,
            speed_frac=speed_frac,
            wait_s=wait_s,
            reason=reason,
            after_work=after_work,
            task=task,
            node=node,
            issued_by=self._person,
        )
        granted = self._authority.grant(machine, command, **self._limits())
        return await self._give(machine, command.command, granted)

    def _limits(self) -> _Limits:
        """Person, areas and validity of a command."""
        return _Limits(person=self._person, areas=self._areas, valid_until_s=self._clock.now_s() + GRANT_S)

    async def _give(self, agent: str, name: str, granted: Message) -> CommandAnswered | None:
        with self._answers.to(name) as answer:
            for _ in range(TRIES):
                self._session.send(agent, granted)
                await asyncio.wait((answer,), timeout=ANSWER_S)
                if answer.done():
                    return answer.result()
        return None

    def calls(self, caller: str) -> bool:
        """Whether an agent calls somebody, as far as the tablet shows."""
        return any(call.subject == (caller, "") for call in self._open_calls())

    def goods_left_on(self, atv: str) -> HelpCall | None:
        """The call for goods on board of this vehicle that wait for a person; None for none."""
        for call in self._open_calls():
            beat = self.machines.get(call.caller)
            briefs = () if beat is None else beat.tasks
            if call.goods and call.caller not in self.machines and self._carries(atv, call.goods):
                return call  # For a station's call, the vehicle's own last message shows its load.
            for brief in briefs:
                if brief.task == call.goods and brief.stranded is not UNSET and brief.stranded.atv == atv:
                    return call
        return None

    def _carries(self, atv: str, task: str) -> bool:
        heard = self.heard.get(atv)
        brief = None if heard is None else heard.heartbeat.task
        return brief is not None and brief.task == task

    def _open_calls(self) -> Iterator[HelpCall]:
        """The calls on the tablet."""
        for call, heard_s in self._calls.values():
            if call.state is not CallState.ENDED and self._clock.now_s() - heard_s <= CALL_OLD_S:
                yield call

    def _on_message(self, _sender: str, message: Message) -> None:
        if isinstance(message, AtvHeartbeat):
            self.heard[message.atv] = LastHeard(message, self._clock.now_s())
        elif isinstance(message, HelpCall):
            before = self._calls.get(message.subject)
            if before is None or _order(before[0]) < _order(message):
                self._calls[message.subject] = message, self._clock.now_s()
        elif isinstance(message, MachineHeartbeat):
            self.machines[message.machine] = message
        elif isinstance(message, CommandAnswered):
            self._answers.take(message)


def _order(call: HelpCall) -> tuple[int, int]:
    return call.incarnation, call.number
