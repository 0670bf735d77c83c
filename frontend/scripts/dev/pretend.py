"""A pretended factory for work on the panels: plausible motion, auctions and orders, no agents.

It speaks in the very structs of `dray.gateway.live.frames` and `views`, so that a panel which works here reads
the real stream. What it pretends is coarse: vehicles drive evenly, never wait for one another, and material
appears when it is needed.
"""

from __future__ import annotations

import heapq
import math
import random
import time
from dataclasses import dataclass, field

import msgspec

from dray.gateway.live.frames import Delta, Snapshot
from dray.gateway.live.views import (
    AtvView,
    BidView,
    BriefView,
    BufferView,
    FactoryView,
    GoalView,
    MachineView,
    OpenTaskView,
    OrderItemView,
    OrderView,
    RefusalView,
    TaskView,
)
from dray.plant.model import PlantFile

STEP_S = 0.1
HEARTBEAT_S = 1.0
LOAD_S = 15.0


class Roads:
    """Shortest ways over the plant's lanes."""

    def __init__(self, plant: PlantFile) -> None:
        self.at = {node.id: (node.x_m, node.y_m) for node in plant.nodes}
        self.next: dict[str, list[tuple[str, float]]] = {node.id: [] for node in plant.nodes}
        for lane in plant.lanes:
            length = math.dist(self.at[lane.start], self.at[lane.end])
            self.next[lane.start].append((lane.end, length))
            if lane.both_ways:
                self.next[lane.end].append((lane.start, length))

    def way(self, start: str, end: str) -> tuple[list[str], float]:
        """Nodes after `start` up to `end`, and the length in metres."""
        best = {start: 0.0}
        came: dict[str, str] = {}
        heap = [(0.0, start)]
        while heap:
            far, node = heapq.heappop(heap)
            if node == end:
                break
            for after, length in self.next[node]:
                if far + length < best.get(after, math.inf):
                    best[after] = far + length
                    came[after] = node
                    heapq.heappush(heap, (far + length, after))
        nodes: list[str] = []
        node = end
        while node != start:
            nodes.insert(0, node)
            node = came[node]
        return nodes, best[end]


@dataclass
class Vehicle:
    """What the pretence knows of a vehicle beyond its view."""

    view: AtvView
    speed_mps: float
    way: list[str]
    beat_s: float
    job: TaskView | None = None
    steps: list[tuple[str, str | float]] = field(default_factory=list)
    """What remains to be done: ("drive", node), ("wait", seconds), ("phase", name)."""


class Pretend:
    """The whole factory; `step` moves it on, `delta` says what changed."""

    def __init__(self, plant: PlantFile, speed: float, seed: int, *, faults: bool) -> None:
        self.plant = plant
        self.roads = Roads(plant)
        self.speed = speed
        self.chance = random.Random(seed)
        self.faults = faults
        self.now_s = 0.0
        self.began_at_s = time.time()
        self.number = 0
        self.serial = 200
        self.delivered: list[tuple[float, float]] = []
        self.ways: dict[tuple[str, str], tuple[list[str], float]] = {}
        self.stations = {s.id: s.node for s in (*plant.storages, *plant.machines, *plant.warehouses)}
        self.tasks: dict[str, TaskView] = {}
        self.orders: dict[str, OrderView] = {}
        self.changed: dict[str, set[str]] = {"atv": set(), "machine": set(), "task": set(), "order": set()}
        self.gone: list[str] = []
        self.machines = {m.id: self.new_machine(i) for i, m in enumerate(plant.machines)}
        self.atvs = {spec.id: self.new_vehicle(i) for i, spec in enumerate(plant.fleet)}
        self.first_orders()

    # --- beginning --------------------------------------------------------------------------------

    def new_vehicle(self, i: int) -> Vehicle:
        spec = self.plant.fleet[i]
        kind = next(t for t in self.plant.vehicle_types if t.id == spec.type)
        x, y = self.roads.at[spec.node]
        view = AtvView(
            id=spec.id, type=spec.type, status="idle", x_m=x, y_m=y, heading_rad=self.chance.uniform(-3, 3),
            speed_mps=0.0, node=spec.node, battery_frac=spec.battery_frac, software="dev", seen_at_s=time.time(),
        )  # fmt: skip
        vehicle = Vehicle(view, kind.max_speed_mps, [], self.chance.random() * HEARTBEAT_S)
        charger = next((c for c in self.plant.chargers if c.node == spec.node), None)
        if charger:
            view.status, view.dwell_point, view.battery_frac = "charging", charger.id, 0.21
        parking = next((p for p in self.plant.parkings if p.node == spec.node), None)
        if parking:
            view.dwell_point = parking.id
        if self.faults and i == 7:
            view.status, view.problem = "error", "load shifted, waits for a person"
        if self.faults and i == 2:
            view.link, view.via = "mesh", self.plant.fleet[3].id
        return vehicle

    def new_machine(self, i: int) -> MachineView:
        spec = self.plant.machines[i]
        making = spec.makes[i % len(spec.makes)]
        product = next(p for p in self.plant.products if p.id == making.product)
        buffers = []
        for line in product.bill:
            material = next(m for m in self.plant.materials if m.id == line.material)
            level = self.chance.randint(material.buffer // 3, material.buffer)
            buffers.append(
                BufferView(
                    item=material.id, level=level, capacity=material.buffer, reorder_point=material.lot
                )
            )
        quantity = self.chance.choice([40, 60, 80])
        view = MachineView(
            id=spec.id, name=spec.name, status="producing", product=product.id, seen_at_s=time.time(),
            goals=(GoalView(goal=f"G-{i}", product=product.id, quantity=quantity, made=quantity // 3, delivered=0),),
            buffers=tuple(buffers), software="dev",
            goods=(BufferView(item=product.id, level=quantity // 3, capacity=spec.goods_capacity),),
        )  # fmt: skip
        if self.faults and i == 4:
            view.status, view.problem = "error", "spindle fault"
        if i == 10:
            view.status, view.goals, view.product = "idle", (), ""
        return view

    def first_orders(self) -> None:
        customers = ["Nordwerk", "Alta Motores", "Hydra Pumps", "Werk Ost", "Riva Drives"]
        statuses = ["in_production", "in_production", "in_delivery", "released", "stored", "delivered"]
        for i, status in enumerate(statuses):
            product = self.plant.products[i % len(self.plant.products)]
            quantity = (i + 2) * 20
            done = {"delivered": quantity, "in_delivery": quantity * 2 // 3}.get(status, 0)
            made = {"delivered": quantity, "in_delivery": quantity, "in_production": quantity // 2}.get(
                status, 0
            )
            self.add_order(
                customers[i % 5], f"PO-{4711 + i}", product.id, quantity,
                due=time.time() + (i - 0.5) * 1800, status=status, made=made, delivered=done,
            )  # fmt: skip

    def add_order(
        self, customer: str, reference: str | None, product: str, quantity: int, *,
        due: float | None, status: str, made: int = 0, delivered: int = 0,
    ) -> OrderView:  # fmt: skip
        self.serial += 1
        order = OrderView(
            id=f"O-{self.serial}", customer=customer, reference=reference, status=status, created_at_s=time.time(),  # type: ignore[arg-type]
            items=(OrderItemView(product=product, quantity=quantity, made=made, delivered=delivered),),
            due_at_s=due, delivered_at_s=time.time() - 600 if status == "delivered" else None,
        )  # fmt: skip
        self.orders[order.id] = order
        self.changed["order"].add(order.id)
        return order

    # --- time -------------------------------------------------------------------------------------

    def wall(self, factory_s: float) -> float:
        return self.began_at_s + factory_s / self.speed

    def run_until(self, factory_s: float) -> None:
        while self.now_s + STEP_S <= factory_s:
            self.now_s += STEP_S
            for vehicle in self.atvs.values():
                self.move(vehicle, STEP_S)
            if self.chance.random() < 0.012 * len(self.machines) * STEP_S:
                self.open_task()
            if self.chance.random() < STEP_S:
                self.work_machines()

    def move(self, vehicle: Vehicle, step_s: float) -> None:
        view = vehicle.view
        before = view.status
        if view.status != "error":
            self.carry_on(vehicle, step_s)
        use = 0.000004 if vehicle.way else 0.000001
        view.battery_frac = max(
            0.12, min(1.0, view.battery_frac + (0.0001 if before == "charging" else -use))
        )
        vehicle.beat_s -= step_s
        if vehicle.beat_s <= 0 or view.status != before:
            vehicle.beat_s = HEARTBEAT_S if vehicle.job or vehicle.way else 5 * HEARTBEAT_S
            view.seen_at_s = self.wall(self.now_s)
            view.way = tuple(vehicle.way)
            self.changed["atv"].add(view.id)

    def carry_on(self, vehicle: Vehicle, step_s: float) -> None:
        view = vehicle.view
        if vehicle.way:
            self.drive(vehicle, vehicle.speed_mps * step_s)
            return
        view.speed_mps = 0.0
        if not vehicle.steps:
            return
        verb, what = vehicle.steps[0]
        if verb == "wait" and float(what) > 0:
            vehicle.steps[0] = (verb, float(what) - step_s)
            return
        vehicle.steps.pop(0)
        if verb == "drive":
            vehicle.way = list(self.way(view.node, str(what))[0])
            view.speed_mps = vehicle.speed_mps
        elif verb == "phase":
            self.enter(vehicle, str(what))

    def drive(self, vehicle: Vehicle, metres: float) -> None:
        view = vehicle.view
        while metres > 0 and vehicle.way:
            x, y = self.roads.at[vehicle.way[0]]
            left = math.hypot(x - view.x_m, y - view.y_m)
            if left > 1e-9:
                view.heading_rad = math.atan2(y - view.y_m, x - view.x_m)
            if left > metres:
                view.x_m += (x - view.x_m) * metres / left
                view.y_m += (y - view.y_m) * metres / left
                return
            view.x_m, view.y_m, view.node = x, y, vehicle.way.pop(0)
            metres -= left

    def way(self, start: str, end: str) -> tuple[list[str], float]:
        if (start, end) not in self.ways:
            self.ways[start, end] = self.roads.way(start, end)
        return self.ways[start, end]

    # --- tasks ------------------------------------------------------------------------------------

    def open_task(self) -> None:
        free = [v for v in self.atvs.values() if v.job is None and v.view.status == "idle"]
        machine = self.chance.choice(list(self.machines.values()))
        if not free or machine.status in ("error", "idle"):
            return
        out = self.chance.random() < 0.25
        item = machine.goods[0].item if out else self.chance.choice(machine.buffers).item
        stores = [s for s in self.plant.storages if any(st.material == item for st in s.stocks)]
        source = machine.id if out else self.chance.choice(stores or list(self.plant.storages)).id
        target = next(w.id for w in self.plant.warehouses if w.kind == "delivery") if out else machine.id
        self.serial += 1
        task = TaskView(
            id=f"{machine.id}-{self.serial}", kind="transport", coordinator=machine.id, item=item,
            quantity=self.chance.choice([20, 24, 40]), sources=(source,), source=source, destination=target,
            opened_at_s=self.wall(self.now_s), deadline_at_s=self.wall(self.now_s + 400), radius_m=30.0,
        )  # fmt: skip
        self.bid(task, free[:12])
        self.contract(task, machine)

    def bid(self, task: TaskView, free: list[Vehicle]) -> None:
        bids = []
        loaded = self.way(self.stations[task.source], self.stations[task.destination])[1]
        for vehicle in free:
            empty = self.way(vehicle.view.node, self.stations[task.source])[1]
            parts = {
                "empty_way": empty / vehicle.speed_mps, "loaded_way": loaded / vehicle.speed_mps + 2 * LOAD_S,
                "energy": 4 + 12 * (1 - vehicle.view.battery_frac), "suitability": 6.0 * (vehicle.view.type == "heavy"),
            }  # fmt: skip
            total = sum(parts.values())
            bids.append(
                BidView(
                    bidder=vehicle.view.id,
                    role="primary",
                    round=1,
                    total_s=total,
                    parts_s=parts,
                    finish_at_s=self.wall(self.now_s + total),
                    source=task.source,
                )
            )
        bids.sort(key=lambda b: b.total_s)
        if len(bids) > 2 and self.chance.random() < 0.2:
            bids[0].answer = "busy"
            bids = [*bids[1:], bids[0]]
        others = [v for v in self.atvs.values() if v not in free][:8]
        task.refusals = tuple(self.refusal(v) for v in others)
        task.bids = tuple(bids)

    def refusal(self, vehicle: Vehicle) -> RefusalView:
        view = vehicle.view
        if view.status == "charging":
            reason, detail = "battery", f"{view.battery_frac:.0%} left"
        elif view.status == "error":
            reason, detail = "not_fit", ""
        else:
            reason, detail = "busy", ""
        return RefusalView(agent=view.id, role="primary", round=1, reason=reason, detail=detail)

    def contract(self, task: TaskView, machine: MachineView) -> None:
        first, *others = task.bids
        first.answer = "accepted"
        task.primary, task.state = first.bidder, "contracted"
        task.contracted_at_s, task.promised_at_s = self.wall(self.now_s), first.finish_at_s
        vehicle = self.atvs[first.bidder]
        due = first.finish_at_s
        brief = BriefView(
            task=task.id, epoch=1, role="primary", coordinator=machine.id, phase="approaching",
            item=task.item, quantity=task.quantity, due_at_s=due,
        )  # fmt: skip
        vehicle.job, vehicle.view.task, vehicle.view.status, vehicle.view.dwell_point = (
            task,
            brief,
            "working",
            "",
        )
        watcher = next((b for b in others if b.answer == ""), None)
        if watcher:
            task.secondary, watcher.answer = watcher.bidder, "accepted"
            view = self.atvs[watcher.bidder].view
            view.watches = (*view.watches, msgspec.structs.replace(brief, role="secondary", phase=None))
            self.changed["atv"].add(view.id)
        vehicle.steps = [
            ("drive", self.stations[task.source]), ("phase", "loading"), ("wait", LOAD_S),
            ("phase", "carrying"), ("drive", self.stations[task.destination]), ("phase", "unloading"),
            ("wait", LOAD_S), ("phase", "done"),
        ]  # fmt: skip
        machine.tasks = (
            *machine.tasks,
            OpenTaskView(
                task=task.id, epoch=1, item=task.item, quantity=task.quantity, source=task.source,
                destination=task.destination, deadline_at_s=task.deadline_at_s, primary=task.primary,
                secondary=task.secondary,
            ),
        )  # fmt: skip
        for buffer in machine.buffers:
            if buffer.item == task.item and task.destination == machine.id:
                buffer.on_order += task.quantity
        self.tasks[task.id] = task
        task.phase = "approaching"
        self.changed["task"].add(task.id)
        self.changed["machine"].add(machine.id)

    def enter(self, vehicle: Vehicle, phase: str) -> None:
        task, view = vehicle.job, vehicle.view
        if task is None or view.task is None:
            return
        self.changed["task"].add(task.id)
        if phase != "done":
            task.phase = view.task.phase = phase
            if phase == "carrying":
                view.load, view.load_quantity = task.item, task.quantity
            return
        self.finish(vehicle, task)

    def finish(self, vehicle: Vehicle, task: TaskView) -> None:
        view = vehicle.view
        task.state, task.phase, task.closed_at_s = "delivered", "", self.wall(self.now_s)
        self.delivered.append((self.now_s, (task.closed_at_s - task.opened_at_s) * self.speed))
        vehicle.job, view.task, view.status, view.load, view.load_quantity = None, None, "idle", "", 0
        if task.secondary:
            watcher = self.atvs[task.secondary].view
            watcher.watches = tuple(w for w in watcher.watches if w.task != task.id)
        machine = self.machines[task.coordinator]
        machine.tasks = tuple(t for t in machine.tasks if t.task != task.id)
        for buffer in machine.buffers:
            if buffer.item == task.item and task.destination == machine.id:
                buffer.on_order = max(0, buffer.on_order - task.quantity)
                buffer.level = min(buffer.capacity, buffer.level + task.quantity)
        if task.source == machine.id:
            machine.goods[0].level = max(0, machine.goods[0].level - task.quantity)
        self.changed["machine"].add(machine.id)
        dwell_points = [
            p for p in self.plant.parkings if all(v.view.dwell_point != p.id for v in self.atvs.values())
        ]
        if dwell_points:
            dwell_point = min(
                dwell_points, key=lambda p: math.dist(self.roads.at[p.node], (view.x_m, view.y_m))
            )
            view.dwell_point = dwell_point.id
            vehicle.steps = [("drive", dwell_point.node)]
        closed = [t.id for t in self.tasks.values() if t.closed_at_s is not None]
        for old in closed[:-50]:
            del self.tasks[old]
            self.gone.append(f"task:{old}")

    def work_machines(self) -> None:
        for machine in self.machines.values():
            if not machine.goals or machine.status == "error":
                continue
            machine.seen_at_s = self.wall(self.now_s)
            self.changed["machine"].add(machine.id)
            if self.chance.random() > 0.02:
                continue
            machine.status = "producing" if all(b.level for b in machine.buffers) else "starved"
            if machine.status != "producing":
                continue
            for buffer in machine.buffers:
                buffer.level -= 1
            goal = machine.goals[0]
            goal.made = min(goal.quantity, goal.made + 1)
            machine.goods[0].level = min(machine.goods[0].capacity, machine.goods[0].level + 1)

    # --- telling ----------------------------------------------------------------------------------

    def factory(self) -> FactoryView:
        times = sorted(seconds for _, seconds in self.delivered[-200:])
        count = [0] * 12
        for at_s, _ in self.delivered:
            slot = 11 - int((self.now_s - at_s) // 300)
            if slot >= 0:
                count[slot] += 1
        past = [62, 70, 68, 80, 92, 84, 96, 104, 99, 101, 110, 0]
        return FactoryView(
            orders_open=len(self.orders), orders_delivered=1, on_time_frac=0.974, starved_frac=0.008,
            transport_p50_s=times[len(times) // 2] if times else None,
            transport_p95_s=times[int(len(times) * 0.95)] if times else None,
            deliveries_per_hour=tuple(12.0 * n or p for n, p in zip(count, past, strict=True)),
            atvs_by_status=tally([v.view.status for v in self.atvs.values()]),
            machines_by_status=tally([m.status for m in self.machines.values()]), speed=self.speed,
        )  # fmt: skip

    def snapshot(self) -> Snapshot:
        return Snapshot(
            number=self.number, at_s=time.time(), plant=self.plant.plant, factory=self.factory(),
            atvs=tuple(v.view for v in self.atvs.values()), machines=tuple(self.machines.values()),
            tasks=tuple(self.tasks.values()), orders=tuple(self.orders.values()),
        )  # fmt: skip

    def delta(self) -> Delta:
        self.number += 1
        changed, self.changed = self.changed, {kind: set() for kind in self.changed}
        gone, self.gone = self.gone, []
        return Delta(
            number=self.number, at_s=time.time(), factory=self.factory() if self.number % 5 == 0 else None,
            atvs=tuple(self.atvs[i].view for i in changed["atv"]),
            machines=tuple(self.machines[i] for i in changed["machine"]),
            tasks=tuple(self.tasks[i] for i in changed["task"] if i in self.tasks),
            orders=tuple(self.orders[i] for i in changed["order"]), gone=tuple(gone),
        )  # fmt: skip


def tally(statuses: list[str]) -> dict[str, int]:
    return {status: statuses.count(status) for status in set(statuses)}
