"""Plain bodies for agents under test: they do what a real body does, in as few lines as can be.

Ways are driven hop by hop and every hop takes the same time; nothing has kinematics or a battery that
empties. What cannot be done is refused with a report, as `dray.ports.Body` promises. A body tells when it
will have something to say (`next_s`), and says it when it is stepped.
"""

from __future__ import annotations

from collections.abc import Callable

from dray.body import (
    ActionDone,
    ActionFailed,
    Admit,
    Broken,
    Charge,
    CloseDock,
    CycleDone,
    CycleFailed,
    Drive,
    Drop,
    GateState,
    GoodsArrived,
    Hold,
    Instruction,
    NodePassed,
    OpenDock,
    Pick,
    ProblemCleared,
    ProblemRaised,
    Repaired,
    Report,
    StartCycle,
    StockChanged,
    Unhold,
    VehicleState,
    WayDone,
    WorkcellState,
)
from dray.messages import Link, Pose
from dray.plant import Plant

NEVER_S = float("inf")

HOP_S = 3.0
"""From a node to the next one."""

TRANSFER_S = 5.0
"""A pick or a drop: long enough that messages come and go meanwhile."""

CHARGE_S = 60.0

Transfer = Callable[[str, Pick | Drop, tuple[str, int]], str]
"""Asked with (vehicle, manoeuvre, what is on board) at the end of every pick and drop; why not, or nothing."""


class PlainVehicle:
    """A vehicle's body.

    Args:
        atv: its id.
        plant: where the lanes are.
        node: where it stands at the beginning.
        transfer: hands loads over.

    Attributes:
        moved: hops that were driven, for whoever checks that it stands.
        refused: why an instruction could not be carried out, oldest first.
    """

    def __init__(self, atv: str, plant: Plant, node: str, transfer: Transfer) -> None:
        self.atv = atv
        self.node = node
        self.load = ("", 0)
        self.held = False
        self.problem = ""
        self.link = Link.WLAN
        self.battery_frac = 0.9
        self.moved = 0
        self.refused: list[str] = []
        self._plant = plant
        self._transfer = transfer
        self._way: Drive | None = None
        self._index = 0
        self.action: Pick | Drop | Charge | None = None
        self._due_s = NEVER_S
        self._left_s = 0.0
        """What was left of the hop or action when it was stopped."""
        self._now_s = 0.0

    @property
    def stopped(self) -> bool:
        return self.held or bool(self.problem)

    @property
    def next_s(self) -> float:
        return NEVER_S if self.stopped else self._due_s

    @property
    def next_node(self) -> str:
        return self.node if self._way is None else self._way.nodes[self._index + 1]

    def sense(self) -> VehicleState:
        spot = self._plant.nodes[self.node]
        return VehicleState(
            pose=Pose(x_m=spot.x_m, y_m=spot.y_m, heading_rad=0.0),
            node=self.node,
            next_node=self.next_node,
            next_node_s=0.0 if self._way is None else HOP_S,
            speed_mps=0.0 if self._way is None or self.stopped else 1.0,
            battery_frac=self.battery_frac,
            load=self.load[0],
            load_quantity=self.load[1],
            held=self.held,
            charging=isinstance(self.action, Charge),
            link=self.link,
            problem=self.problem,
        )

    def instruct(self, instruction: Instruction, now_s: float) -> list[Report]:
        self._now_s = now_s
        if isinstance(instruction, Drive):
            return self._drive(instruction)
        if isinstance(instruction, Pick | Drop | Charge):
            return self._act(instruction)
        if isinstance(instruction, Hold | Unhold):
            self._stop_or_go(lambda: setattr(self, "held", isinstance(instruction, Hold)))
        return []

    def break_down(self, reason: str, now_s: float) -> list[Report]:
        self._now_s = now_s
        self._stop_or_go(lambda: setattr(self, "problem", reason))
        return [ProblemRaised(reason=reason)]

    def repair(self, now_s: float) -> list[Report]:
        self._now_s = now_s
        self._stop_or_go(lambda: setattr(self, "problem", ""))
        return [ProblemCleared()]

    def stand_still(self) -> None:
        """Its power was cut: whatever it was doing is over, and nobody is told."""
        self._way, self.action, self._due_s = None, None, NEVER_S

    def step(self, now_s: float) -> list[Report]:
        """What was due is done."""
        self._now_s = now_s
        if self._way is not None:
            self.moved += 1
            self._index += 1
            return self._pass(self._way)
        action, self.action, self._due_s = self.action, None, NEVER_S
        assert action is not None
        if isinstance(action, Charge):
            self.battery_frac = 1.0
            return [ActionDone(order=action.order)]
        reason = self._transfer(self.atv, action, self.load)
        if reason:
            return [ActionFailed(order=action.order, reason=reason)]
        self.load = (action.item, action.quantity) if isinstance(action, Pick) else ("", 0)
        return [ActionDone(order=action.order)]

    def _drive(self, drive: Drive) -> list[Report]:
        reports: list[Report] = []
        if drive.nodes[0] != self.next_node:
            return self._refuse(drive.order, f"a way from {drive.nodes[0]}, it is at {self.next_node}")
        if isinstance(self.action, Pick | Drop):
            reports += self._refuse(self.action.order, "a new way was given")
        under_way = self._way is not None
        self.action, self._way = None, drive
        if under_way:
            self._index = -1  # It finishes the lane that it is on: the first node is still ahead.
            return reports
        self._index = 0
        return reports + self._pass(drive)

    def _pass(self, way: Drive) -> list[Report]:
        self.node = way.nodes[self._index]
        passed = NodePassed(
            order=way.order, node=self.node, index=self._index, battery_frac=self.battery_frac
        )
        if self._index + 1 < len(way.nodes):
            self._begin(HOP_S)
            return [passed]
        self._way, self._due_s = None, NEVER_S
        return [passed, WayDone(order=way.order, node=self.node)]

    def _act(self, action: Pick | Drop | Charge) -> list[Report]:
        reason = self._why_not(action)
        if reason:
            return self._refuse(action.order, reason)
        self.action = action
        self._begin(CHARGE_S if isinstance(action, Charge) else TRANSFER_S)
        return []

    def _why_not(self, action: Pick | Drop | Charge) -> str:
        station = action.charger if isinstance(action, Charge) else action.station
        if self._way is not None:
            return "the way is not finished"
        if isinstance(self.action, Pick | Drop):
            return "busy with another action"
        if self._plant.node_of(station) != self.node:
            return f"not at {station}"
        if isinstance(action, Drop) and not self.load[0]:
            return "nothing on board"
        if isinstance(action, Pick) and self.load[0]:
            return f"{self.load[0]} is on board"
        return ""

    def _refuse(self, order: int, reason: str) -> list[Report]:
        self.refused.append(reason)
        return [ActionFailed(order=order, reason=reason)]

    def _begin(self, span_s: float) -> None:
        self._due_s, self._left_s = self._now_s + span_s, span_s

    def _stop_or_go(self, change: Callable[[], None]) -> None:
        before = self.stopped
        change()
        if self.stopped and not before:
            self._left_s = self._due_s - self._now_s
        elif before and not self.stopped:
            self._due_s = self._now_s + self._left_s if self._way or self.action else NEVER_S


class PlainWorkcell:
    """A machine's body: cycles take material at their beginning, the dock opens for one load at a time.

    Args:
        machine: its id.
        plant: bills of material.
        stock: pieces at hand at the beginning.
    """

    def __init__(self, machine: str, plant: Plant, stock: dict[str, int] | None = None) -> None:
        self.machine = machine
        self.stock = dict.fromkeys(plant.materials_of(machine), 0) | dict(stock or {})
        self.seq = 0
        self.cycling = ""
        self.broken = ""
        self.consumed: dict[str, int] = {}
        self.made: dict[str, int] = {}
        self._docks: dict[str, tuple[str, int]] = {}
        self._plant = plant
        self._due_s = NEVER_S

    @property
    def next_s(self) -> float:
        return NEVER_S if self.broken else self._due_s

    def sense(self) -> WorkcellState:
        return WorkcellState(stock=dict(self.stock), seq=self.seq, cycling=self.cycling, broken=self.broken)

    def instruct(self, instruction: Instruction, now_s: float) -> list[Report]:
        if isinstance(instruction, StartCycle):
            return self._start(instruction.product, now_s)
        if isinstance(instruction, OpenDock):
            self._docks[instruction.vehicle] = (instruction.item, instruction.quantity)
        elif isinstance(instruction, CloseDock):
            self._docks.pop(instruction.vehicle, None)
        return []

    def break_down(self, reason: str) -> list[Report]:
        """It stands; a running cycle ends when its time had come, or after the repair."""
        self.broken = reason
        return [Broken(reason=reason)]

    def repair(self) -> list[Report]:
        self.broken = ""
        return [Repaired()]

    def step(self, _now_s: float) -> list[Report]:
        """The running cycle ends."""
        product, self.cycling, self._due_s = self.cycling, "", NEVER_S
        self.made[product] = self.made.get(product, 0) + 1
        self.stock[product] = self.stock.get(product, 0) + 1
        self.seq += 1
        return [CycleDone(product=product, seq=self.seq)]

    def transfer(self, vehicle: str, item: str, change: int) -> tuple[str, list[Report]]:
        """A vehicle puts pieces in, or takes them out if `change` is negative: once for each opening."""
        if self._docks.get(vehicle) != (item, abs(change)):
            return "the dock is shut", []
        if self.stock.get(item, 0) + change < 0:
            return "not there", []
        material = self._plant.materials.get(item)
        if change > 0 and material is not None and self.stock[item] + change > material.buffer:
            return "no room", []
        del self._docks[vehicle]
        self.stock[item] = self.stock.get(item, 0) + change
        self.seq += 1
        return "", [StockChanged(item=item, change=change, seq=self.seq, vehicle=vehicle)]

    def _start(self, product: str, now_s: float) -> list[Report]:
        bill = self._plant.products[product].bill
        short = any(self.stock.get(line.material, 0) < line.quantity for line in bill)
        if self.cycling or short:
            return [CycleFailed(product=product, reason="cycling" if self.cycling else "material is missing")]
        for line in bill:
            self.stock[line.material] -= line.quantity
            self.consumed[line.material] = self.consumed.get(line.material, 0) + line.quantity
        self.cycling, self._due_s = product, now_s + self._plant.cycle_s(self.machine, product)
        return []


class PlainGate:
    """The gate of the delivery warehouses: counts pieces in, up to what was admitted."""

    def __init__(self) -> None:
        self.admitted: dict[str, int] = {}
        self.arrived: dict[str, int] = {}

    next_s = NEVER_S

    def sense(self) -> GateState:
        return GateState(arrived=dict(self.arrived))

    def instruct(self, instruction: Instruction, _now_s: float) -> list[Report]:
        if not isinstance(instruction, Admit):
            return []
        goal = instruction.goal
        self.admitted[goal] = instruction.quantity
        arrived = self.arrived.setdefault(goal, 0)
        return [GoodsArrived(goal=goal, arrived=arrived, admitted=instruction.quantity)]

    def step(self, _now_s: float) -> list[Report]:
        return []

    def put(self, goal: str, quantity: int) -> tuple[str, list[Report]]:
        """Pieces of a goal are brought."""
        arrived = self.arrived.get(goal, 0) + quantity
        if arrived > self.admitted.get(goal, 0):
            return "not admitted", []
        self.arrived[goal] = arrived
        return "", [GoodsArrived(goal=goal, arrived=arrived, admitted=self.admitted[goal])]


PlainBody = PlainVehicle | PlainWorkcell | PlainGate
