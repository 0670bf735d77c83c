"""A person's commands to vehicles and machines: each correct one is repeated until it is answered, any other is given once with a random grant."""

from __future__ import annotations

import asyncio
from hashlib import sha256
from random import Random
from typing import TypeVar

from dray.adapters.security.signing import SigningKey
from dray.messages import CommandAnswered, MachineCommand, Message, VehicleCommand
from dray.ports import Bus, Clock
from dray_sim.people.answers import Answers

AGAIN_S = 2.0
"""A command that must be heard is said again after this long."""

GRANT_S = 30.0
"""Longer than the slowest link takes."""

FORGER = SigningKey(sha256(b"somebody whom no vehicle trusts").digest())

Command = TypeVar("Command", VehicleCommand, MachineCommand)


class CommandGiver:
    """Signs and sends the commands of one person.

    Args:
        bus: joined at once.
        clock: the plant's clock.
        authority: grants correct commands.
        person: the person's name, which is also the name on the bus.
        areas: ids of the operators' areas.
        random: the source of chance for grants.
    """

    def __init__(
        self,
        bus: Bus,
        clock: Clock,
        authority: SigningKey,
        *,
        person: str,
        areas: tuple[str, ...],
        random: Random,
    ) -> None:
        self._session = bus.join(person, self._on_message)
        self._clock = clock
        self._authority = authority
        self._person = person
        self._areas = areas
        self._random = random
        self._answers = Answers()

    def give(self, agent: str, command: Command) -> None:
        """Give a command once. One in ten has no grant, one in ten a forged one, one in five a grant for one area only."""
        self._session.send(agent, self._granted_somehow(agent, command))

    async def repeat_until_answered(self, agent: str, command: Command) -> CommandAnswered:
        """Give a command with a correct grant until it is answered."""
        with self._answers.to(command.command) as answer:
            while not answer.done():
                self._session.send(agent, self._granted(self._authority, agent, command, None))
                await asyncio.wait((answer,), timeout=AGAIN_S)
        return answer.result()

    def _granted_somehow(self, agent: str, command: Command) -> Command:
        how = self._random.random()
        if how < 0.1:
            return command
        if how < 0.2:
            return self._granted(FORGER, agent, command, None)
        area = (self._random.choice(self._areas),) if how < 0.4 and self._areas else None
        return self._granted(self._authority, agent, command, area)

    def _granted(
        self, key: SigningKey, agent: str, command: Command, areas: tuple[str, ...] | None
    ) -> Command:
        until_s = self._clock.now_s() + GRANT_S
        return key.grant(agent, command, person=self._person, areas=areas, valid_until_s=until_s)

    def _on_message(self, _sender: str, message: Message) -> None:
        if isinstance(message, CommandAnswered):
            self._answers.take(message)
