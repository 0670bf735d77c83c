"""An operator's work with the load of a dead vehicle: it is brought back by hand, or goods are handed to another vehicle.

goods, things  FETCH_GOODS -> hold them out -> taken; else as everything else
all else       carry it to where it belongs; goods that lie where nobody fetches them are written off (WRITE_OFF)
"""

from __future__ import annotations

import asyncio
from random import Random

from dray.messages import AtvHeartbeat, MachineCommandKind
from dray.plant import Plant
from dray.ports import Clock
from dray_sim.people.habits import Habits
from dray_sim.people.hands import Hands
from dray_sim.people.tablet import Tablet

GLANCE_S = 1.0
"""Interval at which a person who holds goods out checks whether they were taken."""


class Loads:
    """One operator's work with loads.

    Args:
        hands: to take them with.
        tablet: to tell machines about them.
        plant: where they belong.
        clock: the plant's clock.
        habits: how this person works.
        random: the source of chance for the time of carrying.
        chance: the source of chance for holding goods out.

    Attributes:
        handed_over: how often another vehicle has taken goods.
    """

    def __init__(
        self,
        hands: Hands,
        tablet: Tablet,
        plant: Plant,
        clock: Clock,
        habits: Habits,
        random: Random,
        chance: Random,
    ) -> None:
        self._hands, self._tablet, self._plant, self._clock = hands, tablet, plant, clock
        self.handed_over = 0
        self._habits, self._random, self._chance = habits, random, chance

    async def see_to(self, atv: str, heartbeat: AtvHeartbeat, item: str, quantity: int) -> None:
        """Bring back or hand over a load that was taken off a dead vehicle.

        Args:
            atv: the vehicle.
            heartbeat: its last.
            item: the item in hands.
            quantity: pieces of it.
        """
        brief = heartbeat.task
        machine = brief.coordinator if brief is not None else ""
        places = (*self._plant.machines, *self._plant.stores)
        is_goods = item not in self._plant.materials and machine in places
        task = brief.task if brief is not None and is_goods else ""
        if task and self._habits.hands_over_frac and self._chance.random() < self._habits.hands_over_frac:
            node = self._hands.node_beside(atv)
            if node and await self._hand_over(machine, task, item, quantity, node):
                self.handed_over += 1
                return
        await asyncio.sleep(self._random.uniform(*self._habits.carry_s))
        place = self._hands.put_down(item, quantity, heartbeat.node, machine)
        if task and place != machine:
            await self._tablet.tell(machine, MachineCommandKind.WRITE_OFF, task=task)

    async def _hand_over(self, machine: str, task: str, item: str, quantity: int, node: str) -> bool:
        """Have another vehicle come for goods; False when it has not."""
        answer = await self._tablet.tell(machine, MachineCommandKind.FETCH_GOODS, task=task, node=node)
        if answer is None or not answer.done:
            return False
        self._hands.hold_out(item, quantity, node)
        until_s = self._clock.now_s() + self._chance.uniform(*self._habits.hold_s)
        while self._clock.now_s() < until_s:
            await asyncio.sleep(GLANCE_S)
            if not self._hands.holds(item, quantity, node):
                return True
        self._hands.take_back(item, quantity, node)
        return False
