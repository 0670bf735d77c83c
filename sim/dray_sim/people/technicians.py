"""People who look after machines (paper, case 1): they come when one is broken, and repair it; or they hand its goals over.

A technician is on duty, has a tablet that shows the machines' heartbeats, and does one thing at a time. A machine
that calls for help gets the technician whom it asks. If a repair takes longer than the goals can wait, they are
handed over first, and the machine is out of service meanwhile.

    short      react -> take -> promise -> walk -> mend -> CLEAR FAULT
    long       react -> take -> walk -> HAND OVER -> TAKE OUT -> mend -> CLEAR FAULT -> PUT IN
"""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from dataclasses import dataclass, field
from random import Random
from typing import TYPE_CHECKING

from msgspec import UNSET

from dray.messages import CommandRefusal, MachineCommandKind, MachineHeartbeat, ProblemKind
from dray.messages.kinds import Kind
from dray.messages.people.command import PROMISE_MAX_S
from dray.plant.people import people_of
from dray_sim.people.areas import EVERYWHERE, area_at
from dray_sim.people.duty import PersonOnDuty
from dray_sim.people.habits import Range
from dray_sim.people.hands import Hands
from dray_sim.people.tablet import Tablet

if TYPE_CHECKING:
    from dray_sim.factory.sim_factory import SimFactory

LOOK_S = 5.0
"""Interval between two glances at the tablet."""


@dataclass(frozen=True, slots=True)
class Skill:
    """A technician's skill. Ranges of seconds have a lowest and a highest value.

    Attributes:
        react_s: from seeing a broken machine to the first action.
        walk_s: to the machine.
        mend_s: time of a repair, by the kind of the problem; `other_s` applies to any other or unknown kind.
        other_s: time of a repair of any other kind.
        estimate: the promised time relative to the real one.
        promises_frac: the chance that the technician promises to come.
        longest_s: longest repair without a handover; after it the machine is taken out of service.
    """

    react_s: Range = (5.0, 30.0)
    walk_s: Range = (15.0, 90.0)
    mend_s: Mapping[ProblemKind, Range] = field(default_factory=dict)
    other_s: Range = (60.0, 480.0)
    estimate: Range = (1.0, 1.5)
    promises_frac: float = 1.0
    longest_s: float = 300.0


class Technician:
    """One person, who looks after the machines of one area and joins the bus as `technician-<area>`.

    Args:
        area: for which machines; area: responsible for the machines in it;
        factory: where.
        factory: the workplace.
        random: the source of chance of this person's life.

    Attributes:
        name: on the bus.
        duty: the person's state on the bus, and the calls of machines.
        mended: how many machines were put right.
        handed_over: how many of them had lost their goals before.
    """

    def __init__(self, area: str, factory: SimFactory, random: Random, skill: Skill) -> None:
        self.name = f"technician-{area}"
        self.mended = self.handed_over = 0
        self._area = area
        self._plant = factory.plant
        self._hands = Hands(factory)
        self._random = random
        self._skill = skill
        self._out: set[str] = set()
        """Machines that are out of service by this person's word."""
        own = None if area == EVERYWHERE else (area,)
        self.duty = PersonOnDuty(
            self.name,
            own,
            keys=factory.keys,
            bus=factory.bus,
            clock=factory.clock,
            looks_after=lambda call: not call.goods and self._is_here(call.caller),
            hours=people_of(self._plant, area),
        )
        self._tablet = Tablet(
            self.name,
            own,
            keys=factory.keys,
            bus=factory.bus,
            clock=factory.clock,
            authority=factory.authority,
        )

    async def run(self) -> None:
        """Work until cancelled."""
        with self._tablet.on():
            async with asyncio.TaskGroup() as group:
                group.create_task(self.duty.run())
                group.create_task(self._look())

    async def _look(self) -> None:
        """See which machine needs somebody, and see to it, one at a time."""
        while True:
            await asyncio.sleep(LOOK_S)
            needy = sorted(
                machine for machine, beat in self._tablet.machines.items() if self._concerns(machine, beat)
            )
            if needy:
                await self._attend(needy[0])
            for machine in sorted(self._out):
                await self._bring_back(machine)

    def _concerns(self, machine: str, beat: MachineHeartbeat) -> bool:
        """Whether it is broken and asks this person, or calls nobody, stands here, and no other person is on the way."""
        if not beat.problem or machine not in self._plant.machines or not self.duty.is_at_work:
            return False
        if self._tablet.calls(machine):
            return self.duty.shown(machine) is not None
        if not self._is_here(machine):
            return False
        return beat.help is UNSET or beat.help.promised_by in ("", self.name)

    def _is_here(self, machine: str) -> bool:
        """Whether this is a machine of the area: to another one this person may say nothing."""
        return machine in self._plant.machines and self._area == area_at(
            self._plant, *self._plant.position_of(machine)
        )

    async def _attend(self, machine: str) -> None:
        await asyncio.sleep(self._draw(self._skill.react_s))
        about = self._tablet.machines[machine].about_problem
        kind = ProblemKind.UNKNOWN if about is UNSET else about.kind
        walk_s = self._draw(self._skill.walk_s)
        mend_s = self._draw(self._skill.mend_s.get(kind, self._skill.other_s))
        is_long = mend_s > self._skill.longest_s
        shown = self.duty.shown(machine)
        if shown is not None and not await self.duty.take(shown.call, walk_s + mend_s):
            return
        if not is_long and self._random.random() < self._skill.promises_frac:
            wait_s = min((walk_s + mend_s) * self._draw(self._skill.estimate), PROMISE_MAX_S)
            await self._tablet.tell(machine, MachineCommandKind.PROMISE, wait_s=wait_s)
        await asyncio.sleep(walk_s)
        if not self._hands.machine_problem(machine):
            return
        if is_long:
            await self._tablet.tell(machine, MachineCommandKind.HAND_OVER)
            await self._tablet.tell(
                machine, MachineCommandKind.TAKE_OUT, wait_s=mend_s, reason="it is being mended"
            )
            self._out.add(machine)
            self.handed_over += 1
        await asyncio.sleep(mend_s)
        self._hands.mend_machine(machine)
        await self._tablet.tell(machine, MachineCommandKind.CLEAR_FAULT)
        self.mended += 1

    async def _bring_back(self, machine: str) -> None:
        """Put a machine into service again; a silent one is told later, and one that is broken again is repaired first."""
        answer = await self._tablet.tell(machine, MachineCommandKind.PUT_IN)
        if answer is not None and (answer.done or answer.reason is CommandRefusal.IN_SERVICE):
            self._out.discard(machine)

    def _draw(self, seconds: Range) -> float:
        return self._random.uniform(*seconds)


def employ(factory: SimFactory, *, seed: int, skill: Skill | None = None) -> tuple[Technician, ...]:
    """One technician for every area of a factory; the caller lets them `run`.

    Args:
        factory: where they work.
        seed: each draws from a generator of its own that follows from it.
        skill: of all technicians.
    """
    crew = tuple(
        Technician(area, factory, Random(f"{seed} technician {area}"), skill or Skill())
        for area in factory.plant.areas or (EVERYWHERE,)
    )
    for technician in crew:
        factory.bus.kinds[technician.duty.agent_id] = Kind.OPERATOR
    return crew
