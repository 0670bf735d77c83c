"""What the panels see: the shapes of the live entities on `/api/stream` (`dray.gateway.frames`) and in REST.

A view is a whole entity, replaced as a whole: the newest one wins. Times are seconds since 1970 on
the wall clock (`*_at_s`), whatever the speed of the factory's clock; durations and speeds are the
factory's own. The TypeScript types of the panels are generated from these structs.

Whoever is limited to areas is shown less of an entity, and `*` in place of a vehicle that stands elsewhere
(`dray.gateway.projection.sight`).
"""

from __future__ import annotations

from dray.gateway.views.alert import AlertKind, AlertResponse, AlertView
from dray.gateway.views.atv import AtvView, BriefView, HelpView
from dray.gateway.views.base import View
from dray.gateway.views.clock import ClockView
from dray.gateway.views.command import CommandState, CommandView
from dray.gateway.views.factory import AudienceView, FactoryView, FaultView, UseView
from dray.gateway.views.machine import BufferView, GoalView, MachineView, OpenTaskView
from dray.gateway.views.news import NewsView
from dray.gateway.views.order import OrderItemView, OrderView
from dray.gateway.views.shutout import ShutOutView
from dray.gateway.views.station import StationView, StockView
from dray.gateway.views.task import BidView, CarrierView, RefusalView, TaskView
from dray.gateway.views.trial import TrialView
from dray.gateway.views.why import PassedView, RefusedView, WhyView

__all__ = [
    "AlertKind",
    "AlertResponse",
    "AlertView",
    "AtvView",
    "AudienceView",
    "BidView",
    "BriefView",
    "BufferView",
    "CarrierView",
    "ClockView",
    "CommandState",
    "CommandView",
    "FactoryView",
    "FaultView",
    "GoalView",
    "HelpView",
    "MachineView",
    "NewsView",
    "OpenTaskView",
    "OrderItemView",
    "OrderView",
    "PassedView",
    "RefusalView",
    "RefusedView",
    "ShutOutView",
    "StationView",
    "StockView",
    "TaskView",
    "TrialView",
    "UseView",
    "View",
    "WhyView",
]
