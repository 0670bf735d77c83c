"""The messages between an agent and its body: instructions down, reports up.

An agent decides, a body acts. Each kind of body has a file: `vehicle`, `workcell` (of a machine), `storage`, `gate` (of the
delivery warehouses) and `operator`; shared parts are in `dock`, `documents` and `words`.
"""

from __future__ import annotations

from dray.body.any_body import (
    BodyState,
    Instruction,
    Report,
)
from dray.body.bounds import (
    WORDS_MAX,
    bounded,
)
from dray.body.dock import (
    Book,
    CloseDock,
    DockReady,
    OpenDock,
    StockChanged,
)
from dray.body.documents import (
    DocumentRead,
    ReadDocument,
)
from dray.body.gate import (
    Admit,
    GateProblem,
    GateState,
    GoodsArrived,
    HoldOrder,
)
from dray.body.operator import (
    CallPart,
    CallReplied,
    DutyChanged,
    DutyState,
    OperatorReport,
    ShowCalls,
    ShownCall,
)
from dray.body.storage import (
    FillTo,
    Refill,
    StorageInstruction,
    StorageState,
)
from dray.body.vehicle import (
    SLOWEST_FRAC,
    ActionDone,
    ActionFailed,
    Charge,
    Drive,
    Drop,
    Hold,
    LimitSpeed,
    LinkNoticed,
    NodePassed,
    Pick,
    ProblemCleared,
    ProblemRaised,
    ReleaseWay,
    Unhold,
    UnplacedVehicle,
    VehicleInstruction,
    VehicleReport,
    VehicleState,
    WayDone,
)
from dray.body.words import (
    Word,
    WordTaken,
)
from dray.body.workcell import (
    Broken,
    CycleDone,
    CycleFailed,
    Repaired,
    ResetFault,
    SetPace,
    StartCycle,
    WorkcellInstruction,
    WorkcellReport,
    WorkcellState,
)
from dray.messages.floor.obstacle import WayBlocked, WayFree

__all__ = [
    "SLOWEST_FRAC",
    "WORDS_MAX",
    "ActionDone",
    "ActionFailed",
    "Admit",
    "BodyState",
    "Book",
    "Broken",
    "CallPart",
    "CallReplied",
    "Charge",
    "CloseDock",
    "CycleDone",
    "CycleFailed",
    "DockReady",
    "DocumentRead",
    "Drive",
    "Drop",
    "DutyChanged",
    "DutyState",
    "FillTo",
    "GateProblem",
    "GateState",
    "GoodsArrived",
    "Hold",
    "HoldOrder",
    "Instruction",
    "LimitSpeed",
    "LinkNoticed",
    "NodePassed",
    "OpenDock",
    "OperatorReport",
    "Pick",
    "ProblemCleared",
    "ProblemRaised",
    "ReadDocument",
    "Refill",
    "ReleaseWay",
    "Repaired",
    "Report",
    "ResetFault",
    "SetPace",
    "ShowCalls",
    "ShownCall",
    "StartCycle",
    "StockChanged",
    "StorageInstruction",
    "StorageState",
    "Unhold",
    "UnplacedVehicle",
    "VehicleInstruction",
    "VehicleReport",
    "VehicleState",
    "WayBlocked",
    "WayDone",
    "WayFree",
    "Word",
    "WordTaken",
    "WorkcellInstruction",
    "WorkcellReport",
    "WorkcellState",
    "bounded",
]
