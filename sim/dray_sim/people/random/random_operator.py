"""A person who presses buttons at random: the worst operator that a factory can have.

Commands come in any order, to any vehicle, in any state; most of them must be refused. Some have a grant for one area
only, independent of the vehicle's position; some have a forged one or none. When the quiet phase begins, everything
is put right again.
"""

from __future__ import annotations

import asyncio
from hashlib import sha256
from random import Random

from dray.adapters.security.signing import SigningKey
from dray.messages import CommandAnswered, CommandKind, CommandRefusal, Message, VehicleCommand
from dray.ports import Bus, Clock
from dray_sim.people.answers import Answers

NAME = "passerby"
"""Its name on the bus. The name is in the traces of runs, and so it stays."""

GAP_S = 40.0
"""Between two commands, in the mean."""

AGAIN_S = 2.0
"""A command that must be heard is said again after this long."""

WEIGHTS = {
    CommandKind.STOP: 4,
    CommandKind.ACKNOWLEDGE: 3,
    CommandKind.RESUME: 4,
    CommandKind.SET_SPEED: 2,
    CommandKind.PROMISE: 1,
    CommandKind.HAND_OVER: 1,
    CommandKind.TAKE_OUT: 1,
    CommandKind.PUT_IN: 1,
}

LONGEST_PROMISE_S = 60.0

GRANT_S = 30.0
"""Longer than the slowest link takes."""

FORGER = SigningKey(sha256(b"somebody whom no vehicle trusts").digest())


class RandomOperator:
    """Gives commands until the quiet phase, then takes them back.

    Args:
        bus: joined at once.
        clock: the plant's clock.
        authority: grants correct commands.
        fleet: ids of the vehicles.
        areas: ids of the operators' areas.
        random: the source of chance, except for the grants.
        grants: the source of chance for grants.
    """

    def __init__(
        self,
        bus: Bus,
        clock: Clock,
        authority: SigningKey,
        *,
        fleet: tuple[str, ...],
        areas: tuple[str, ...],
        random: Random,
        grants: Random,
    ) -> None:
        self._session = bus.join(NAME, self._on_message)
        self._clock = clock
        self._authority = authority
        self._fleet = fleet
        self._areas = areas
        self._random = random
        self._grants = grants
        self._said = 0
        self._answers = Answers()

    async def meddle(self) -> None:
        """Give commands until cancelled."""
        kinds, weights = tuple(WEIGHTS), tuple(WEIGHTS.values())
        while True:
            await asyncio.sleep(self._random.expovariate(1.0 / GAP_S))
            kind = self._random.choices(kinds, weights)[0]
            atv = self._random.choice(self._fleet)
            self._session.send(atv, self._granted_somehow(atv, self._command(kind)))

    async def put_right(self) -> None:
        """Let every vehicle drive on, at full speed and in service; returns when all do."""
        async with asyncio.TaskGroup() as group:
            for atv in self._fleet:
                group.create_task(self._let_go(atv))

    async def _let_go(self, atv: str) -> None:
        await self._repeat_until_answered(atv, CommandKind.SET_SPEED)
        await self._repeat_until_answered(atv, CommandKind.PUT_IN)
        while True:
            await self._repeat_until_answered(atv, CommandKind.ACKNOWLEDGE)
            resumed = await self._repeat_until_answered(atv, CommandKind.RESUME)
            if resumed.done or resumed.reason == CommandRefusal.NOT_STOPPED:
                return
            # A broken vehicle refuses to be acknowledged until it is repaired.
            await asyncio.sleep(AGAIN_S)

    async def _repeat_until_answered(self, atv: str, kind: CommandKind) -> CommandAnswered:
        """Give a command until it is answered."""
        command = self._command(kind, speed_frac=1.0)
        with self._answers.to(command.command) as answer:
            while not answer.done():
                self._session.send(atv, self._granted(self._authority, atv, command, None))
                await asyncio.wait((answer,), timeout=AGAIN_S)
        return answer.result()

    def _command(self, kind: CommandKind, speed_frac: float | None = None) -> VehicleCommand:
        self._said += 1
        draw = self._random.uniform
        return VehicleCommand(
            command=f"{NAME}-{self._said}",
            kind=kind,
            speed_frac=(speed_frac or draw(0.2, 1.0)) if kind is CommandKind.SET_SPEED else None,
            wait_s=draw(1.0, LONGEST_PROMISE_S) if kind is CommandKind.PROMISE else None,
            reason="a look at its wheels" if kind is CommandKind.TAKE_OUT else "",
            after_work=kind is CommandKind.TAKE_OUT and draw(0.0, 1.0) < 0.5,
            issued_by=NAME,
        )

    def _granted_somehow(self, atv: str, command: VehicleCommand) -> VehicleCommand:
        how = self._grants.random()
        if how < 0.1:
            return command
        if how < 0.2:
            return self._granted(FORGER, atv, command, None)
        area = (self._grants.choice(self._areas),) if how < 0.4 and self._areas else None
        return self._granted(self._authority, atv, command, area)

    def _granted(
        self, key: SigningKey, atv: str, command: VehicleCommand, areas: tuple[str, ...] | None
    ) -> VehicleCommand:
        until_s = self._clock.now_s() + GRANT_S
        return key.grant(atv, command, person=NAME, areas=areas, valid_until_s=until_s)

    def _on_message(self, _sender: str, message: Message) -> None:
        if isinstance(message, CommandAnswered):
            self._answers.take(message)
