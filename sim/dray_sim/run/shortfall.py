"""Why a plant has not done more: every wait of a transport and of a machine, with its cause.

A listener that looks at the heartbeats and at the storages every `LOOK_S` and adds up. It takes no part, and the run
is the same without it. `dray_sim.run.verdict` puts the result into words.

A transport waits for *material* that no storage has, or that storages have promised to others, for a *charger* when able vehicles have no battery left, for
*vehicles* when they all carry something else, at a *dock* that is held, or in a *lane*. A machine without material,
or without room for its goods, loses its time to the cause for which the transport waits or has waited. If the
transport did not wait and still came too late, the cause is the machine's own *buffer*. The wait for material is
mostly over when a transport is announced, because stations promise the load first: it counts as the transport's.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from typing import Protocol

from dray.messages import (
    AtvHeartbeat,
    AtvStatus,
    Event,
    MachineHeartbeat,
    MachineStatus,
    MaterialWait,
    Message,
    Phase,
    Role,
    TaskBrief,
)
from dray.messages.contract import DockHeld, Refusal
from dray.messages.fact import BidRefused, TaskOpened
from dray.messages.heartbeat_stock import with_stock
from dray.overload import Overload
from dray.plant import Plant

LOOK_S = 10.0
"""Interval between two looks: short beside any transport, and long beside the cost of a look."""

BIDDING_S = 15.0
"""Time of a normal auction, in which no vehicle is missing yet."""

HELD_S = 12.0
"""A held dock is asked again every 5 s; without another question for this long it counts as open."""

STANDS_S = 20.0
"""Time below walking speed in the lane, with way ahead; turning and braking are shorter."""

REMEMBERED_S = 20.0
"""Shortest wait that counts: a transport that has waited for less came too late for another reason."""

HUNGRY_FRAC = 0.3
"""Battery level below which an idle vehicle looks for a charger, or should."""

Cause = tuple[str, str]
"""Kind and name: material, charger, vehicles, dock, lane or buffer, and which."""


class HasStock(Protocol):
    """A storage as it is looked at."""

    @property
    def stock(self) -> Mapping[str, int]: ...


class Shortfall:
    """Adds up the waits and their causes.

    Args:
        plant: abilities, docks and bills.
        storages: give their present stock.

    Attributes:
        looked_s: how long it has looked.
        open_s: transports' time from the announcement to the end.
        wait_s: of that, waiting time by cause.
        machine_s: machines' time by machine and status.
        lost_s: machines' time without material or room, by cause.
        left_s: machines' time for the goals that were open at the last look.
        working_s, charging_s, hungry_s: vehicles' time by vehicle: under contract, charging, idle with a low battery.
        docked_s: vehicles' time at docks under contract, by place; more than there is where several stand at one.
        overloaded_s: time in which the demand exceeded the vehicles' capacity (`dray.overload`).
        overloaded_waiting: transports that had waited too long for a vehicle then, at the worst look.
        empty_s: time in which no storage had a container of it, by material.
    """

    def __init__(self, plant: Plant, storages: Mapping[str, HasStock]) -> None:
        self._plant = plant
        self._storages = storages
        self._able = {ability: plant.able(ability) for ability in plant.abilities}
        self._docks: dict[str, list[str]] = {}
        for place in (*plant.machines, *plant.storages, *plant.delivery_warehouses):
            self._docks.setdefault(plant.node_of(place), []).append(place)
        self.looked_s = 0.0
        self.open_s = 0.0
        self.wait_s: dict[Cause, float] = defaultdict(float)
        self.machine_s: dict[str, dict[MachineStatus, float]] = {
            machine: defaultdict(float) for machine in plant.machines
        }
        self.lost_s: dict[Cause, float] = defaultdict(float)
        self.left_s: dict[str, float] = {}
        self.working_s: dict[str, float] = defaultdict(float)
        self.charging_s: dict[str, float] = defaultdict(float)
        self.hungry_s: dict[str, float] = defaultdict(float)
        self.docked_s: dict[str, float] = defaultdict(float)
        self.overloaded_s = 0.0
        self.overloaded_waiting = 0
        self.empty_s: dict[str, float] = defaultdict(float)
        self._machines: dict[str, MachineHeartbeat] = {}
        self._atvs: dict[str, AtvHeartbeat] = {}
        self._refused: dict[str, dict[str, Refusal]] = {}
        """Why vehicles did not bid for open transports the last time."""
        self._held: dict[str, tuple[float, str]] = {}
        """Since when, and at which place, a vehicle's dock was last held."""
        self._moved_s: dict[str, float] = {}
        self._opened_s: dict[str, float] = {}
        self._waited: dict[str, dict[Cause, float]] = {}
        """Waits so far, by open transport."""
        self._needs: dict[str, list[MaterialWait]] = {}
        """By machine: the material that no storage could give it at the last look."""
        self._overload = Overload()
        self._announced_s: dict[str, float] = {}
        """First announcement, by open transport."""
        self._look_s = 0.0

    def on_message(self, at_s: float, _sender: str, address: str, message: Message) -> None:
        """See `Listener`."""
        if isinstance(message, AtvHeartbeat):
            self._note_atv(message)
        elif isinstance(message, MachineHeartbeat):
            self._machines[message.machine] = with_stock(message, self._machines.get(message.machine))
        elif isinstance(message, Event):
            fact = message.fact
            if isinstance(fact, BidRefused) and fact.role is Role.PRIMARY:
                self._refused.setdefault(fact.task, {})[message.agent] = fact.reason
            elif isinstance(fact, TaskOpened):
                self._announced_s.setdefault(fact.task, at_s)
        elif isinstance(message, DockHeld):
            self._held[address.removeprefix(">")] = at_s, message.station
        if at_s >= self._look_s:
            if self.looked_s or self._look_s:
                self._look(at_s, LOOK_S)
            self._look_s = at_s + LOOK_S

    def _note_atv(self, beat: AtvHeartbeat) -> None:
        if beat.speed_mps > 0.01 or not beat.way:
            self._moved_s[beat.atv] = beat.at_s
        self._atvs[beat.atv] = beat

    # --- a look ---

    def _look(self, now_s: float, span_s: float) -> None:
        self.looked_s += span_s
        stock = self._stock()
        for material, spec in self._plant.materials.items():
            if not any(pieces >= spec.lot for pieces in stock.get(material, ())):
                self.empty_s[material] += span_s
        for beat in self._atvs.values():
            self._look_at_atv(beat, span_s)
        open_tasks: set[str] = set()
        for machine, heard in self._machines.items():
            if machine not in self.machine_s:
                continue
            self._look_at_needs(heard, now_s)
            for task in heard.tasks:
                open_tasks.add(task.task)
                self._look_at_task(task, stock, now_s, span_s)
            self._look_at_machine(heard, stock, now_s, span_s)
        self._look_at_demand(now_s, span_s)
        for notes in (self._opened_s, self._waited, self._refused, self._announced_s):
            for ended in [task for task in notes if task not in open_tasks]:
                del notes[ended]

    def _stock(self) -> dict[str, list[int]]:
        """The stock of every material in every storage."""
        found: dict[str, list[int]] = {}
        for storage in self._storages.values():
            for item, pieces in storage.stock.items():
                found.setdefault(item, []).append(pieces)
        return found

    def _look_at_demand(self, now_s: float, span_s: float) -> None:
        waited_s = (
            now_s - self._announced_s[task.task]
            for heard in self._machines.values()
            for task in heard.tasks
            if task.task in self._announced_s and not task.primary and not task.trouble
        )
        if self._overload.look(waited_s, len(self._atvs)):
            self.overloaded_s += span_s
            self.overloaded_waiting = max(self.overloaded_waiting, self._overload.waiting)

    def _look_at_atv(self, beat: AtvHeartbeat, span_s: float) -> None:
        if beat.status is AtvStatus.CHARGING:
            self.charging_s[beat.atv] += span_s
        elif beat.status is AtvStatus.IDLE and beat.battery_frac < HUNGRY_FRAC:
            self.hungry_s[beat.atv] += span_s
        task = beat.task
        if task is None:
            return
        self.working_s[beat.atv] += span_s
        if task.phase in (Phase.LOADING, Phase.UNLOADING, Phase.HANDING_OVER) and not beat.way:
            for place in self._docks.get(beat.node, ()):
                self.docked_s[place] += span_s

    def _look_at_needs(self, heard: MachineHeartbeat, now_s: float) -> None:
        """Count a need's wait for material as that of the transport that was announced for it since the last look."""
        before = self._needs.get(heard.machine, [])
        self._needs[heard.machine] = needs = [wait for wait in heard.waits if wait.short]
        lasting = {(wait.item, wait.since_s) for wait in needs}
        over = [wait for wait in before if (wait.item, wait.since_s) not in lasting]
        for task in heard.tasks:
            of_it = [wait for wait in over if wait.item == task.item]
            if task.task not in self._opened_s and of_it:
                over.remove(of_it[0])
                waited = self._waited.setdefault(task.task, defaultdict(float))
                waited["material", task.item] += now_s - of_it[0].since_s

    def _look_at_task(
        self, task: TaskBrief, stock: dict[str, list[int]], now_s: float, span_s: float
    ) -> None:
        self.open_s += span_s
        opened_s = self._opened_s.setdefault(task.task, now_s)
        cause = self._cause(task, stock, now_s, now_s - opened_s)
        if cause is not None:
            self.wait_s[cause] += span_s
            self._waited.setdefault(task.task, defaultdict(float))[cause] += span_s

    def _cause(
        self, task: TaskBrief, stock: dict[str, list[int]], now_s: float, age_s: float
    ) -> Cause | None:
        """The cause for which a transport waits now."""
        carrier = self._atvs.get(task.primary)
        if carrier is None or not task.primary:
            if self._none_of(task.item, task.quantity, stock):
                return "material", task.item
            return self._nobody(task) if age_s >= BIDDING_S else None
        if carrier.status is AtvStatus.ERROR and carrier.battery_frac <= 0.0:
            return "charger", "all"
        if carrier.task is None or carrier.task.task != task.task:
            return None
        held_s, station = self._held.get(carrier.atv, (-HELD_S, ""))
        if now_s - held_s < HELD_S and not carrier.way:
            if self._none_of(task.item, task.quantity, stock) and carrier.task.phase is Phase.LOADING:
                return "material", task.item
            return "dock", station
        if carrier.task.phase is Phase.LOADING and not carrier.load and task.source in self._storages:
            if self._storages[task.source].stock.get(task.item, 0) < task.quantity:
                return "material", task.item
        if carrier.way and now_s - self._moved_s.get(carrier.atv, now_s) > STANDS_S:
            return "lane", f"{carrier.node} to {carrier.way[0]}"
        return None

    def _none_of(self, item: str, quantity: int, stock: dict[str, list[int]]) -> bool:
        return item in self._plant.materials and not any(pieces >= quantity for pieces in stock.get(item, ()))

    def _nobody(self, task: TaskBrief) -> Cause:
        """Why no vehicle takes a transport: no battery, or all are busy."""
        ability = self._plant.ability_of(task.item)
        able = [self._atvs[atv] for atv in self._able.get(ability, ()) if atv in self._atvs]
        refused = self._refused.get(task.task, {})
        without_battery = sum(
            beat.status is AtvStatus.CHARGING
            or refused.get(beat.atv) is Refusal.BATTERY
            or (beat.task is None and beat.battery_frac < HUNGRY_FRAC)
            or (beat.status is AtvStatus.ERROR and beat.battery_frac <= 0.0)
            for beat in able
        )
        busy = sum(beat.task is not None and beat.status is AtvStatus.WORKING for beat in able)
        return ("charger", "all") if without_battery > busy else ("vehicles", ability)

    def _look_at_machine(
        self, heard: MachineHeartbeat, stock: dict[str, list[int]], now_s: float, span_s: float
    ) -> None:
        machine = heard.machine
        self.machine_s[machine][heard.status] += span_s
        self.left_s[machine] = sum(
            (goal.quantity - goal.made) * self._plant.cycle_s(machine, goal.product)
            for goal in heard.goals
            if machine in self._plant.machines_for(goal.product)
        )
        if heard.status is MachineStatus.STARVED:
            missing = self._missing(heard)
            for item in missing:
                cause = self._blame(heard, item, stock, now_s) or ("buffer", f"{item} at {machine}")
                self.lost_s[cause] += span_s / len(missing)
        elif heard.status is MachineStatus.BLOCKED:
            for item in {level.item for level in heard.goods or () if level.level}:
                cause = self._blame(heard, item, stock, now_s) or ("buffer", f"{item} from {machine}")
                self.lost_s[cause] += span_s / max(1, sum(level.level > 0 for level in heard.goods or ()))

    def _missing(self, heard: MachineHeartbeat) -> list[str]:
        """Materials of which there are too few for the next piece of the first goal that is not done."""
        levels = {level.item: level.level for level in heard.buffers or ()}
        for goal in heard.goals:
            if goal.made < goal.quantity:
                # For a product that is newer than the plant file, only the machine's buffers are known.
                known = self._plant.products.get(goal.product)
                bill = (
                    {line.material: line.quantity for line in known.bill}
                    if known
                    else dict.fromkeys(levels, 1)
                )
                short = [
                    material for material, quantity in bill.items() if levels.get(material, 0) < quantity
                ]
                if short:
                    return short
        return []

    def _blame(
        self, heard: MachineHeartbeat, item: str, stock: dict[str, list[int]], now_s: float
    ) -> Cause | None:
        """The longest wait among the transports of an item, and among its needs without one."""
        waited: dict[Cause, float] = defaultdict(float)
        for wait in self._needs[heard.machine]:
            if wait.item == item:
                waited["material", item] += now_s - wait.since_s
        for task in heard.tasks:
            if task.item == item:
                for cause, seconds in self._waited.get(task.task, {}).items():
                    waited[cause] += seconds
        if waited:
            worst = max(waited, key=lambda cause: waited[cause])
            if waited[worst] >= REMEMBERED_S:
                return worst
        lot = self._plant.materials[item].lot if item in self._plant.materials else 1
        if self._none_of(item, lot, stock):
            return "material", item
        return None
