"""Somebody who presses buttons at random: the worst operator that a factory can have.

Commands come in any order, to any vehicle, whatever it is doing; most of them must be refused. When
the calm begins, everything is put right again.
"""

from __future__ import annotations

import asyncio
from random import Random

from dray.messages import CommandAnswered, CommandKind, Message, VehicleCommand
from dray.ports import Bus

NAME = "passerby"

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
}

LONGEST_PROMISE_S = 60.0


class Passerby:
    """Gives commands until the calm, then takes them back.

    Args:
        bus: joined at once.
        fleet: ids of the vehicles.
        random: the only source of chance.
    """

    def __init__(self, bus: Bus, fleet: tuple[str, ...], random: Random) -> None:
        self._session = bus.join(NAME, self._hear)
        self._fleet = fleet
        self._random = random
        self._said = 0
        self._answered: dict[str, asyncio.Event] = {}

    async def meddle(self) -> None:
        """Give commands until cancelled."""
        kinds, weights = tuple(WEIGHTS), tuple(WEIGHTS.values())
        while True:
            await asyncio.sleep(self._random.expovariate(1.0 / GAP_S))
            kind = self._random.choices(kinds, weights)[0]
            self._session.send(self._random.choice(self._fleet), self._command(kind))

    async def put_right(self) -> None:
        """Let every vehicle drive on, at full speed; returns when all have heard it."""
        async with asyncio.TaskGroup() as group:
            for atv in self._fleet:
                group.create_task(self._let_go(atv))

    async def _let_go(self, atv: str) -> None:
        for kind in (CommandKind.ACKNOWLEDGE, CommandKind.RESUME, CommandKind.SET_SPEED):
            command = self._command(kind, speed_frac=1.0)
            answered = self._answered[command.command] = asyncio.Event()
            while not answered.is_set():
                self._session.send(atv, command)
                try:
                    await asyncio.wait_for(answered.wait(), AGAIN_S)
                except TimeoutError:
                    continue
            del self._answered[command.command]

    def _command(self, kind: CommandKind, speed_frac: float | None = None) -> VehicleCommand:
        self._said += 1
        draw = self._random.uniform
        return VehicleCommand(
            command=f"{NAME}-{self._said}",
            kind=kind,
            speed_frac=(speed_frac or draw(0.2, 1.0)) if kind is CommandKind.SET_SPEED else None,
            wait_s=draw(1.0, LONGEST_PROMISE_S) if kind is CommandKind.PROMISE else None,
            issued_by=NAME,
        )

    def _hear(self, _sender: str, message: Message) -> None:
        if isinstance(message, CommandAnswered) and message.command in self._answered:
            self._answered[message.command].set()
