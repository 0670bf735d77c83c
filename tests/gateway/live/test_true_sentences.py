"""What panels say of silence, places, loads, work, waiting, lack, stocks and lateness, compared with the simulated factory in which it is so or not.

Each sentence stands here with the state in which it is true. Forty minutes with crashes are walked in steps of seconds; what is told
is at most as old as the heartbeats are.
"""

from __future__ import annotations

import asyncio
from collections import Counter, defaultdict
from math import hypot
from random import Random
from typing import Any

from wall_clock import NOW_S

from dray.body import VehicleState
from dray.gateway.access.principal import ADMIN
from dray.gateway.live.projection import Projection
from dray.gateway.live.stream import scope_of
from dray.gateway.live.timescale import TimeScale
from dray.messages.keys import Keys
from dray.plant import default_plant
from dray_sim.clock.loop import clock, run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.people import demand
from dray_sim.people.order_client import OrderClient

LENGTH_S = 2400
STEP_S = 5
AFTER_S = 0.7
FAULT_EVERY_S = 120

BEATS_S = 12.0
"""Two heartbeats of an agent that rests, and a look: what has changed since then may not be told yet."""

LOOKS = 5
"""Looks within which a heartbeat has told what is so: `BEATS_S`, and one more."""

SILENT_S = 40.0
"""Who has been silent for so long is told as silent."""

SILENT = frozenset({"atv_lost", "machine_lost"})

BETWEEN_M = 4.0
"""The fastest vehicle of this plant drives less in half of the time between two looks."""

BATTERY_FRAC = 0.005
"""Panels show whole percents."""


class Walk:
    """What was told at each step, and what was so."""

    def __init__(self, factory: SimFactory, projection: Projection) -> None:
        self.factory, self.projection = factory, projection
        self.down_s: dict[str, float] = {}
        """Agents that are crashed -> since when."""
        self.up_s: dict[str, float] = {}
        """Agents that were started again -> when."""
        self.moved_s: defaultdict[str, list[float]] = defaultdict(list)
        """Vehicles -> the looks at which they moved."""
        self.waited_s: defaultdict[str, list[float]] = defaultdict(list)
        """Vehicles -> the looks at which they were told to wait."""
        self.put_down_s: dict[str, float] = {}
        """Vehicles -> when they were seen first without the load that they had."""
        self.loaded: set[str] = set()
        self.lay: defaultdict[tuple[str, str], list[int]] = defaultdict(list)
        """Storage and material -> pieces at the last looks."""
        self.was: defaultdict[str, list[VehicleState]] = defaultdict(list)
        """Vehicles -> what their bodies sensed at the last looks."""
        self.made_s: dict[str, float] = {}
        """Machines -> when they made something last."""
        self.ended: set[str] = set()
        """Transports whose end was told."""
        self.had_s: dict[tuple[str, str], float] = {}
        """Machine and material -> when it had some last."""
        self.said: Counter[str] = Counter()
        self.wrong: list[tuple[float, str, str]] = []

    def trouble(self, at_s: float) -> None:
        """One agent after the other crashes, and is started again."""
        agents = sorted([*self.factory.vehicles, *self.factory.workcells])
        turn, at = divmod(int(at_s), FAULT_EVERY_S)
        agent = agents[turn * 7 % len(agents)]
        if at == 15 and self.factory.running(agent):
            self.factory.crash(agent)
            self.down_s[agent] = at_s
        elif at == 90 and agent in self.down_s:
            self.factory.restart(agent)
            del self.down_s[agent]
            self.up_s[agent] = at_s

    def look(self, at_s: float) -> None:
        """Compare what is told now with what is so."""
        for vehicle, body in self.factory.vehicles.items():
            state = body.sense()
            self.was[vehicle] = [*self.was[vehicle], state][-LOOKS:]
            if state.speed_mps:
                self.moved_s[vehicle].append(at_s)
            if state.load:
                self.loaded.add(vehicle)
            elif vehicle in self.loaded:
                self.loaded.remove(vehicle)
                self.put_down_s[vehicle] = at_s
        for storage, store in self.factory.floor.storages.items():
            for item, pieces in store.stock.items():
                self.lay[storage, item] = [*self.lay[storage, item], pieces][-LOOKS:]
        for machine, cell in self.factory.workcells.items():
            sensed = cell.sense()
            if sensed.cycling:
                self.made_s[machine] = at_s
            for item, level in sensed.stock.items():
                if level:
                    self.had_s[machine, item] = at_s
        wall_s = NOW_S + at_s
        self.projection.look(wall_s)
        told = scope_of(self.projection, ADMIN).snapshot(0, wall_s)
        self._silence(told, at_s)
        self._vehicles(told, at_s)
        self._making(told, at_s)
        self._waits(told, at_s)
        self._lack(told, at_s)
        self._stocks(told, at_s)
        self._lateness(told, at_s)

    def _claim(self, at_s: float, sentence: str, of: str, *, true: bool) -> None:
        self.said[sentence] += 1
        if not true:
            self.wrong.append((at_s, sentence, of))

    def _silence(self, told: Any, at_s: float) -> None:
        silent = {alert.agent for alert in told.alerts if alert.kind in SILENT}
        for agent in silent:
            is_so = agent in self.down_s or at_s - self.up_s.get(agent, -BEATS_S) < BEATS_S
            self._claim(at_s, "nothing is heard of it", agent, true=is_so)
        for agent, since_s in self.down_s.items():
            if at_s - since_s > SILENT_S:
                self._claim(at_s, "who is silent is told as silent", agent, true=agent in silent)

    def _vehicles(self, told: Any, at_s: float) -> None:
        for atv in told.atvs:
            # Of whoever is silent, or was, it is a memory, and said to be one.
            if atv.id in self.down_s or at_s - self.up_s.get(atv.id, -SILENT_S) < SILENT_S:
                continue
            was = self.was[atv.id]
            away_m = [hypot(each.pose.x_m - atv.x_m, each.pose.y_m - atv.y_m) for each in was]
            is_so = min(away_m) <= BETWEEN_M
            self._claim(at_s, "it is there", atv.id, true=is_so)
            loads = {(each.load, each.load_quantity) for each in was}
            self._claim(at_s, "it carries this", atv.id, true=(atv.load, atv.load_quantity) in loads)
            full = [each.battery_frac for each in was]
            is_so = min(full) - BATTERY_FRAC <= atv.battery_frac <= max(full) + BATTERY_FRAC
            self._claim(at_s, "its battery is so full", atv.id, true=is_so)
            if atv.status == "charging":
                is_so = any(each.charging for each in was)
                self._claim(at_s, "it charges", atv.id, true=is_so)

    def _making(self, told: Any, at_s: float) -> None:
        for machine in told.machines:
            if machine.status == "producing" and machine.id not in self.down_s:
                is_so = at_s - self.made_s.get(machine.id, -LENGTH_S) < BEATS_S
                self._claim(at_s, "it makes something", machine.id, true=is_so)

    def _waits(self, told: Any, at_s: float) -> None:
        for wait in told.waits:
            # It stands since then: it has not driven, but for what heartbeats have not told yet.
            begun_s, moved_s = wait.since_at_s - NOW_S + BEATS_S, self.moved_s[wait.id]
            drove_on = any(begun_s < each <= at_s - BEATS_S for each in moved_s)
            # Who was told to wait at each of the last looks, since whenever, has not driven at each of them.
            told_s = self.waited_s[wait.id]
            told_s.append(at_s)
            first_s = at_s - (LOOKS - 1) * STEP_S - AFTER_S
            drives = all(len(each) >= LOOKS and each[-LOOKS] >= first_s for each in (moved_s, told_s))
            self._claim(at_s, "it waits", wait.id, true=not drove_on and not drives)

    def _lack(self, told: Any, at_s: float) -> None:
        for machine in told.machines:
            if machine.status != "starved" or machine.id in self.down_s:
                continue
            empty = [each.item for each in machine.buffers if each.level == 0]
            for item in empty:
                cell = self.factory.workcells[machine.id].sense()
                has = cell.stock.get(item, 0) > 0 and at_s - self.up_s.get(machine.id, 0.0) > BEATS_S
                is_so = not has or at_s - self.had_s[machine.id, item] < BEATS_S
                self._claim(at_s, "it has none of this material", f"{machine.id} {item}", true=is_so)

    def _stocks(self, told: Any, at_s: float) -> None:
        for station in told.stations:
            for stock in station.stocks:
                lay = self.lay[station.id, stock.item]
                is_so = min(lay) <= stock.level <= max(lay)
                self._claim(at_s, "so much lies in the storage", f"{station.id} {stock.item}", true=is_so)

    def _lateness(self, told: Any, at_s: float) -> None:
        for task in told.tasks:
            if task.kind != "transport" or not task.primary:
                continue
            put_down_s = self.put_down_s.get(task.primary, -BEATS_S)
            if task.state == "delivered" and task.id not in self.ended:
                self.ended.add(task.id)
                # So late as it is told to have come, it has put its load down, or the machine that was down has heard of it.
                heard_s = max(put_down_s, self.up_s.get(task.coordinator, -BEATS_S))
                is_so = abs(task.closed_at_s - NOW_S - heard_s) < BEATS_S
                self._claim(at_s, "it handed over then", task.id, true=is_so)
            elif task.state == "contracted" and task.phase == "carrying" and task.promised_at_s is not None:
                if NOW_S + at_s <= task.promised_at_s:
                    continue
                is_so = task.primary in self.loaded or at_s - put_down_s < BEATS_S
                self._claim(at_s, "it is late, with its load on board", task.id, true=is_so)


def walked(seed: int) -> Walk:
    """Forty minutes of the default plant, whose buffers are nearly empty at first."""
    plant = default_plant()
    projection = Projection(plant.file, TimeScale(0.0, NOW_S))
    walks: list[Walk] = []

    async def main() -> None:
        factory = SimFactory(plant, clock(), seed=seed, traffic=True, stock_frac=(0.0, 0.02))
        walks.append(Walk(factory, projection))
        session = factory.bus.join("panel", lambda _sender, message: projection.fold(message))
        session.subscribe(Keys(plant.id).all_heartbeats)
        session.subscribe(Keys(plant.id).all_events)
        orders = demand.orders(plant, Random(seed), load=0.9, until_s=float(LENGTH_S))
        async with asyncio.TaskGroup() as group:
            tasks = [
                group.create_task(factory.run()),
                group.create_task(OrderClient(factory.bus, factory.clock).place(orders)),
            ]
            for step in range(STEP_S, LENGTH_S, STEP_S):
                # Between heartbeats, too, which come at whole seconds.
                await asyncio.sleep(STEP_S - AFTER_S)
                walks[0].look(step - AFTER_S)
                await asyncio.sleep(AFTER_S)
                walks[0].trouble(float(step))
            for task in tasks:
                task.cancel()

    run(main())
    return walks[0]


def test_what_panels_say_is_so_at_every_step() -> None:
    walk = walked(18)
    assert walk.wrong == []
    # Each of them was said: a test that never hears a sentence proves nothing.
    sentences = (
        "nothing is heard of it",
        "who is silent is told as silent",
        "it is there",
        "it carries this",
        "its battery is so full",
        "it charges",
        "it makes something",
        "it waits",
        "it has none of this material",
        "so much lies in the storage",
        "it handed over then",
        "it is late, with its load on board",
    )
    assert all(walk.said[sentence] > 10 for sentence in sentences), walk.said
