"""Instructions and reports of all kinds of bodies."""

from __future__ import annotations

from dray.body.gate import Admit, GateProblem, GateState, GoodsArrived, HoldOrder
from dray.body.operator import DutyState, OperatorReport, ShowCalls
from dray.body.storage import StorageInstruction, StorageState
from dray.body.vehicle import UnplacedVehicle, VehicleInstruction, VehicleReport, VehicleState
from dray.body.workcell import WorkcellInstruction, WorkcellReport, WorkcellState
from dray.messages.gate import OrderHeld

Instruction = VehicleInstruction | WorkcellInstruction | StorageInstruction | Admit | HoldOrder | ShowCalls
Report = VehicleReport | WorkcellReport | GoodsArrived | GateProblem | OrderHeld | OperatorReport
BodyState = VehicleState | UnplacedVehicle | WorkcellState | StorageState | GateState | DutyState
