"""Commands: a person's requests to vehicles or machines, and their answers.

A command is sent once and never queued: a person must know whether it was heard, and decide again. All panels
of people responsible for the agent show it as sent, and then its outcome.
"""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import Callable
from dataclasses import dataclass, replace
from http import HTTPStatus
from typing import Any, TypeVar, cast

from dray.adapters.security.signing import SigningKey
from dray.gateway.access.limits import Limit
from dray.gateway.access.principal import Principal, Scope
from dray.gateway.factory.awaited import Awaited
from dray.gateway.http.problems import Problem
from dray.gateway.live.places import areas_of
from dray.gateway.live.projection import Projection
from dray.gateway.live.timescale import TimeScale
from dray.gateway.live.views import CommandView
from dray.messages import (
    CommandAnswered,
    CommandKind,
    CommandRefusal,
    MachineCommand,
    Message,
    VehicleCommand,
)
from dray.messages.base import CLOCKS_AGREE_S
from dray.plant import Plant

STOP_VALID_S = 30.0
"""Validity of a stop in wall seconds: over a bad link, a late stop is better than none."""

WORDS_TRIES, WORDS_HZ = 60, 1.0
"""Maximum confirmations of one caller to one place: a burst, and a rate per second. Nobody counts loads
faster. The place writes each to disk, and remembers so many to recognise repetitions
(`dray.adapters.people`)."""

C = TypeVar("C", VehicleCommand, MachineCommand)

SHUTTING_OUT = Principal(kind="admin", id="shut-out", name="", scopes=frozenset({Scope.VEHICLES_STOP}))
"""Sender of the stop for a vehicle that is shut out; the audit log has the person."""


@dataclass(frozen=True, slots=True)
class Sent:
    """A command that was sent.

    Attributes:
        agent: the addressee.
        person: the caller.
        said: the command without its grant.
        answer: the addressee's answer.
        beside: whether it went through the endpoint for stops only (`dray.gateway.stop`), which keeps account
            of it.
        copies: how often it was sent, without the copies that came too late.
    """

    agent: str
    person: str
    said: VehicleCommand | MachineCommand
    answer: asyncio.Future[CommandAnswered]
    beside: bool = False
    copies: int = 1


class Commands:
    """Sends commands and pairs them with their answers.

    Args:
        send: sends a message to one agent.
        authority: signs the grants.
        projection: shows commands, and knows the vehicles' positions.
        floor: knows the areas of positions.
        time: plant clock and wall clock.
        wall_s: the wall clock.
        name: prefix of command names; differs in every run of the gateway.
        timeout_s: wall seconds to wait for the answer.
    """

    def __init__(
        self,
        send: Callable[[str, Message], None],
        *,
        authority: SigningKey,
        projection: Projection,
        floor: Plant,
        time: TimeScale,
        wall_s: Callable[[], float],
        name: str,
        timeout_s: float,
    ) -> None:
        self._send, self._authority = send, authority
        self._projection, self._floor = projection, floor
        self._time, self._wall_s = time, wall_s
        self._timeout_s = timeout_s
        self._sent: Awaited[Sent] = Awaited(name)
        self._words = Limit(wall_s, tries=WORDS_TRIES, rate_hz=WORDS_HZ)

    async def order(
        self,
        atv: str,
        kind: CommandKind,
        *,
        by: Principal,
        command: str | None = None,
        speed_frac: float | None = None,
        wait_s: float | None = None,
        reason: str = "",
        after_work: bool = False,
    ) -> CommandAnswered:
        """Send a command with a grant, and wait for the vehicle's answer.

        Args:
            atv: the vehicle.
            kind: the kind of command.
            by: the caller.
            command: the caller's name for it, if any; one that was sent already is only waited for.
            speed_frac: fraction of the vehicle's own top speed.
            wait_s: duration of the help, or time out of service, in plant seconds.
            reason: why it is taken out of service.
            after_work: whether it is taken out of service only after its present work.

        Raises:
            Problem: 504, the vehicle does not answer in time; 503, too many commands wait; 409, another
                command has this name.
        """
        said = VehicleCommand(
            command=command or self._sent.new_name(),
            kind=kind,
            speed_frac=speed_frac,
            wait_s=wait_s,
            issued_by=by.name,
            reason=reason,
            after_work=after_work,
        )
        return await self.give(atv, said, by=by)

    async def give(
        self, agent: str, said: VehicleCommand | MachineCommand, *, by: Principal
    ) -> CommandAnswered:
        """Send a given command with a grant, and wait for the answer.

        Args:
            agent: a vehicle, a machine or a station.
            said: the command without a grant; one with a known name is only waited for.
            by: the caller.

        Raises:
            Problem: see `order`; 429 for a new confirmation beyond the rate at which people can count.
        """
        name, person = said.command, f"{by.kind}:{by.id}"
        sent = self._sent.get(name)
        if sent is None:
            if isinstance(said, MachineCommand) and said.kind.is_word:
                self._words.take(f"{person} {agent}")
            sent = self._say(agent, said, person, by)
        elif (sent.agent, sent.person, sent.said) != (agent, person, said):
            raise name_used(name)
        elif isinstance(said, MachineCommand) and said.kind.is_word and not sent.answer.done():
            # The place counts it once, however often it arrives; the caller may have to repeat it to get an
            # answer.
            sent = self._sent.keep(name, replace(sent, copies=sent.copies + 1))
            self._send(agent, self._granted(sent, by))
        return await self._wait(name, sent)

    def sent_beside(self, atv: str, said: VehicleCommand, by: Principal) -> bool:
        """Show a stop that went through its own endpoint, and remember its name.

        Returns:
            False when a command of this name was sent here before.
        """
        if said.command in self._sent:
            return False
        sent = Sent(atv, f"{by.kind}:{by.id}", said, _nothing_yet(), beside=True)
        self._show(self._sent.keep(said.command, sent), by)
        return True

    def answered_beside(self, atv: str, name: str, answer: CommandAnswered | None) -> None:
        """Note the outcome of such a stop; None when the vehicle has not answered in time."""
        if answer is not None:
            self.answered(atv, answer)
        else:
            self._projection.commands.end(name, "not_confirmed")

    def went_beside(self, name: str | None) -> bool:
        """Whether the command of this name first went through the endpoint for stops only."""
        sent = None if name is None else self._sent.get(name)
        return sent is not None and sent.beside

    def answered(self, sender: str, answer: CommandAnswered) -> bool:
        """Take in a vehicle's answer; returns whether it is new, in time or late."""
        sent = self._sent.get(answer.command)
        if sent is None or sent.answer.done() or sent.agent != sender:
            return False
        if answer.reason is CommandRefusal.EXPIRED and sent.copies > 1:
            # Each copy of a word has a grant of its own: another one may count.
            self._sent.keep(answer.command, replace(sent, copies=sent.copies - 1))
            return True
        sent.answer.set_result(answer)
        self._projection.commands.end(answer.command, "confirmed" if answer.done else "refused", answer)
        return True

    def ahead_s(self, agent: str) -> float:
        """Seconds that an agent's clock, by which it checks grants, is ahead. Thread-safe."""
        return self._projection.clocks.ahead_s(agent)

    def last_stop(self, atv: str) -> str | None:
        """The name of the last stop sent to a vehicle, by any way; None if none is remembered."""
        stops = (
            name
            for name, sent in self._sent.newest_first()
            if sent.agent == atv and sent.said.kind is CommandKind.STOP
        )
        return next(stops, None)

    def part_with(self, atv: str, by: str) -> None:
        """Stop a vehicle that is shut out, and stop waiting for its answers, which are ignored.

        Args:
            atv: the vehicle.
            by: the name of the person who shut it out.
        """
        why = f"{by} has shut {atv} out: whether it obeys is not known, look at it"
        stop = VehicleCommand(command=self._sent.new_name(), kind=CommandKind.STOP, issued_by=by)
        with contextlib.suppress(Problem):  # too many wait; the exclusion holds anyway
            self._say(atv, stop, SHUTTING_OUT.id, replace(SHUTTING_OUT, name=by))
        for name, sent in self._sent.newest_first():
            if sent.agent == atv and not sent.answer.done():
                unknown = CommandAnswered(command=name, done=False, detail=why)
                sent.answer.set_result(unknown)
                self._projection.commands.end(name, "not_confirmed", unknown)

    def new_name(self) -> str:
        """A new command name."""
        return self._sent.new_name()

    def _say(self, agent: str, said: VehicleCommand | MachineCommand, person: str, by: Principal) -> Sent:
        self._sent.refuse_too_many(person)
        sent = self._sent.keep(said.command, Sent(agent, person, said, _nothing_yet()))
        self._show(sent, by)
        self._send(agent, self._granted(sent, by))
        return sent

    async def _wait(self, name: str, sent: Sent) -> CommandAnswered:
        with self._sent.waiting(sent.person):
            try:
                async with asyncio.timeout(self._timeout_s):
                    return await asyncio.shield(sent.answer)
            except TimeoutError:
                self._projection.commands.end(name, "not_confirmed")
                raise not_confirmed(sent.agent, self._timeout_s) from None

    def _show(self, sent: Sent, by: Principal) -> None:
        said = sent.said
        margin_m = said.kind.margin_m if isinstance(said.kind, CommandKind) else 0.0
        view = CommandView(
            id=said.command,
            atv=sent.agent,
            kind=cast(Any, said.kind.value),
            speed_frac=said.speed_frac,
            by=by.name,
            at_s=self._wall_s(),
        )
        if isinstance(said, MachineCommand):
            near = areas_of(self._floor, sent.agent)
        elif place_m := self._projection.atvs.place_m(sent.agent):
            near = frozenset(self._floor.areas_near(*place_m, margin_m))
        else:
            near = frozenset[str]()
        if by.areas is not None and by.areas.isdisjoint(near):
            near |= by.areas  # a person who stops a vehicle shown elsewhere must see the result
        self._projection.commands.put(view, near)

    def _granted(self, sent: Sent, by: Principal) -> VehicleCommand | MachineCommand:
        # A grant expires after answer timeout plus clock skew, so an unconfirmed command never executes
        # later. Only a stop lasts longer.
        valid_s = STOP_VALID_S if sent.said.kind is CommandKind.STOP else self._timeout_s + CLOCKS_AGREE_S
        until_s = (
            self._time.to_plant_s(self._wall_s()) + valid_s * self._time.speed + self.ahead_s(sent.agent)
        )
        if isinstance(sent.said, MachineCommand):
            return granted(self._authority, sent.agent, sent.said, by, until_s)
        return granted(self._authority, sent.agent, sent.said, by, until_s)


def granted(authority: SigningKey, agent: str, said: C, by: Principal, valid_until_s: float) -> C:
    """A command to one agent with the caller's grant; `valid_until_s` is on the plant's clock."""
    return authority.grant(
        agent,
        said,
        person=f"{by.kind}:{by.id}",
        areas=None if by.areas is None else sorted(by.areas),
        valid_until_s=valid_until_s,
    )


def name_used(name: str) -> Problem:
    """The problem: another command has this name."""
    return Problem(
        HTTPStatus.CONFLICT,
        "command-name-used",
        "The name of the command was used",
        f"another command is called {name}; choose a name that is used once, a UUID say",
    )


def not_confirmed(agent: str, timeout_s: float) -> Problem:
    """The problem: the agent has not answered in time."""
    return Problem(
        HTTPStatus.GATEWAY_TIMEOUT,
        "not-confirmed",
        "Not confirmed",
        f"{agent} has not answered within {timeout_s:g} s: it may or may not have heard; look at it",
    )


def _nothing_yet() -> asyncio.Future[CommandAnswered]:
    return asyncio.get_running_loop().create_future()
