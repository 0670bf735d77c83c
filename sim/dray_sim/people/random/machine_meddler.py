"""A person who presses a machine's buttons at random, as `random_operator` does a vehicle's; the quiet phase undoes all."""

from __future__ import annotations

import asyncio
from random import Random

from dray.adapters.security.signing import SigningKey
from dray.messages import CommandAnswered, CommandRefusal, MachineCommand, MachineCommandKind
from dray.ports import Bus, Clock
from dray_sim.people.random.command_giver import AGAIN_S, CommandGiver

NAME = "meddler"
"""Its name on the bus."""

GAP_S = 60.0
"""Between two commands, in the mean."""

LONGEST_PROMISE_S = 120.0

WEIGHTS = {
    MachineCommandKind.PROMISE: 2,
    MachineCommandKind.CLEAR_FAULT: 2,
    MachineCommandKind.HAND_OVER: 2,
    MachineCommandKind.SET_SPEED: 1,
    MachineCommandKind.RESTART: 1,
    MachineCommandKind.UPDATE: 1,
    MachineCommandKind.TAKE_OUT: 2,
    MachineCommandKind.PUT_IN: 3,
}


class MachineMeddler:
    """Gives commands to machines until the quiet phase, then takes them back.

    Args:
        bus: joined at once.
        clock: the plant's clock.
        authority: grants correct commands.
        machines: their ids.
        areas: ids of the operators' areas.
        random: the only source of chance.
    """

    def __init__(
        self,
        bus: Bus,
        clock: Clock,
        authority: SigningKey,
        *,
        machines: tuple[str, ...],
        areas: tuple[str, ...],
        random: Random,
    ) -> None:
        self._giver = CommandGiver(bus, clock, authority, person=NAME, areas=areas, random=random)
        self._machines = machines
        self._random = random
        self._said = 0

    async def meddle(self) -> None:
        """Give commands until cancelled."""
        kinds, weights = tuple(WEIGHTS), tuple(WEIGHTS.values())
        while True:
            await asyncio.sleep(self._random.expovariate(1.0 / GAP_S))
            machine = self._random.choice(self._machines)
            command = self._command(self._random.choices(kinds, weights)[0])
            self._giver.give(machine, command)

    async def put_right(self) -> None:
        """Let every machine work, at full speed and in service; returns when all do."""
        async with asyncio.TaskGroup() as group:
            for machine in self._machines:
                group.create_task(self._let_work(machine))

    async def _let_work(self, machine: str) -> None:
        await self._repeat_until_answered(machine, MachineCommandKind.SET_SPEED)
        while True:
            answer = await self._repeat_until_answered(machine, MachineCommandKind.PUT_IN)
            if answer.done or answer.reason is CommandRefusal.IN_SERVICE:
                return
            await asyncio.sleep(AGAIN_S)  # A broken machine is not put into service.

    async def _repeat_until_answered(self, machine: str, kind: MachineCommandKind) -> CommandAnswered:
        return await self._giver.repeat_until_answered(machine, self._command(kind, speed_frac=1.0))

    def _command(self, kind: MachineCommandKind, speed_frac: float | None = None) -> MachineCommand:
        self._said += 1
        draw = self._random.uniform
        return MachineCommand(
            command=f"{NAME}-{self._said}",
            kind=kind,
            speed_frac=(speed_frac or draw(0.3, 1.0)) if kind is MachineCommandKind.SET_SPEED else None,
            wait_s=draw(1.0, LONGEST_PROMISE_S) if kind is MachineCommandKind.PROMISE else None,
            reason="new bearings" if kind is MachineCommandKind.TAKE_OUT else "",
            after_work=kind is MachineCommandKind.TAKE_OUT and draw(0.0, 1.0) < 0.5,
            issued_by=NAME,
        )
