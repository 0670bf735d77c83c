"""Views: the shapes of the live entities on `/api/stream` (`dray.gateway.live.frames`) and in REST.

A view is a whole entity; the newest one replaces it. Times are wall clock seconds since 1970 (`*_at_s`), at
any factory speed; durations and speeds are the factory's own. The panels' TypeScript types are generated from
these structs.

A caller limited to areas sees less of an entity, and `*` in place of a vehicle elsewhere
(`dray.gateway.live.visibility`).
"""

from __future__ import annotations

from dray.gateway.live.views.agent import ClockView, ProbationView, ShutOutView, SilenceView
from dray.gateway.live.views.alert import AlertKind, AlertRecord, AlertResponse, AlertView, AlertWordView
from dray.gateway.live.views.atv import (
    AtvView,
    BodyWaitView,
    BriefView,
    HelpView,
    OutOfServiceView,
    ProblemView,
    RemovalRefusalView,
    RemovalView,
)
from dray.gateway.live.views.base import View
from dray.gateway.live.views.cause import CauseView, FailureView, HandoverView, LackView
from dray.gateway.live.views.command import CommandState, CommandView
from dray.gateway.live.views.factory import (
    AudienceView,
    FactoryView,
    FaultView,
    ScenarioCheckView,
    ScenarioView,
    StepView,
    UseView,
)
from dray.gateway.live.views.floor.closure import ClosureView, CornerView, LaneView
from dray.gateway.live.views.floor.obstacle import ObstacleView
from dray.gateway.live.views.floor.wait import WaitCauseView, WaitKind, WaitView
from dray.gateway.live.views.load import DoubtView, LoadView, ToComeView
from dray.gateway.live.views.machine import (
    BufferView,
    DocumentView,
    GoalView,
    MachineView,
    OpenTaskView,
)
from dray.gateway.live.views.news import NewsView
from dray.gateway.live.views.order import OrderItemView, OrderView
from dray.gateway.live.views.station import StationView, StockView
from dray.gateway.live.views.task import BidView, CarrierView, RefusalView, StrandedView, TaskView
from dray.gateway.live.views.why import PassedView, RefusedView, WhyView

__all__ = [
    "AlertKind",
    "AlertRecord",
    "AlertResponse",
    "AlertView",
    "AlertWordView",
    "AtvView",
    "AudienceView",
    "BidView",
    "BodyWaitView",
    "BriefView",
    "BufferView",
    "CarrierView",
    "CauseView",
    "ClockView",
    "ClosureView",
    "CommandState",
    "CommandView",
    "CornerView",
    "DocumentView",
    "DoubtView",
    "FactoryView",
    "FailureView",
    "FaultView",
    "GoalView",
    "HandoverView",
    "HelpView",
    "LackView",
    "LaneView",
    "LoadView",
    "MachineView",
    "NewsView",
    "ObstacleView",
    "OpenTaskView",
    "OrderItemView",
    "OrderView",
    "OutOfServiceView",
    "PassedView",
    "ProbationView",
    "ProblemView",
    "RefusalView",
    "RefusedView",
    "RemovalRefusalView",
    "RemovalView",
    "ScenarioCheckView",
    "ScenarioView",
    "ShutOutView",
    "SilenceView",
    "StationView",
    "StepView",
    "StockView",
    "StrandedView",
    "TaskView",
    "ToComeView",
    "UseView",
    "View",
    "WaitCauseView",
    "WaitKind",
    "WaitView",
    "WhyView",
]
