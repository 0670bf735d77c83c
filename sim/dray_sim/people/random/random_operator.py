"""A person who presses buttons at random: the worst operator that a factory can have.

Commands come in any order, to any vehicle, in any state; most of them must be refused. Some have a grant for one area
only, independent of the vehicle's position; some have a forged one or none. When the quiet phase begins, everything
is put right again.
"""

from __future__ import annotations

import asyncio
from random import Random

from dray.adapters.security.signing import SigningKey
from dray.messages import CommandAnswered, CommandKind, CommandRefusal, VehicleCommand
from dray.ports import Bus, Clock
from dray_sim.people.random.command_giver import AGAIN_S, CommandGiver

NAME = "passerby"
"""Its name on the bus. The name is in the traces of runs, and so it stays."""

GAP_S = 40.0
"""Between two commands, in the mean."""

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
        self._giver = CommandGiver(bus, clock, authority, person=NAME, areas=areas, random=grants)
        self._fleet = fleet
        self._random = random
        self._said = 0

    async def meddle(self) -> None:
        """Give commands until cancelled."""
        kinds, weights = tuple(WEIGHTS), tuple(WEIGHTS.values())
        while True:
            await asyncio.sleep(self._random.expovariate(1.0 / GAP_S))
            kind = self._random.choices(kinds, weights)[0]
            atv = self._random.choice(self._fleet)
            self._giver.give(atv, self._command(kind))

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
        return await self._giver.repeat_until_answered(atv, self._command(kind, speed_frac=1.0))

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
