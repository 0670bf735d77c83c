"""A machine's status and heartbeat, composed from its parts."""

from __future__ import annotations

from msgspec import UNSET, UnsetType

from dray.messages import (
    NOTHING_KNOWN,
    BufferLevel,
    DocumentBrief,
    JoiningMachine,
    MachineHeartbeat,
    MachineStatus,
)
from dray.messages.fact import MachineStatusChanged
from dray.messages.heartbeat import Making
from dray.messages.heartbeat_stock import STOCK_EVERY_S
from dray.messages.keys import Keys
from dray.plant.model import MachineSpec
from dray.protocol.contract_net.trust.probation import Probation
from dray.protocol.liveness.suspicion import WORKING_INTERVAL_S
from dray.protocol.machine.cycle import Cycle
from dray.protocol.machine.documents import GoalDocuments
from dray.protocol.machine.material_flow import MaterialFlow
from dray.protocol.machine.people.breakdown import Breakdown
from dray.protocol.machine.people.command_handling import MachineCommandHandling
from dray.protocol.machine.production import GoalBook
from dray.protocol.machine.supply import Supply
from dray.protocol.runtime.life import Life
from dray.protocol.runtime.shutdown import GracefulShutdown
from dray.protocol.traffic.reservations.reservation_handling import ReservationHandling

Stock = tuple[tuple[BufferLevel, ...], tuple[BufferLevel, ...], tuple[DocumentBrief, ...]]
"""Materials, finished products, and documents."""

_Levels = tuple[BufferLevel, ...] | UnsetType


class StatusReport:
    """Composes a machine's heartbeats.

    Args:
        software: the version it runs.
        joining: its own data, if others' plant files lack it.
        keys: the plant's bus keys.
        goals, supply, flow, cycle, documents, breakdown, commands, probation, reservation_handling: the machine's parts.
        shutdown: whether it was asked to leave.

    Attributes:
        status: the status last reported.
    """

    def __init__(
        self,
        software: str,
        joining: JoiningMachine | None,
        keys: Keys,
        goals: GoalBook,
        supply: Supply,
        flow: MaterialFlow,
        cycle: Cycle,
        documents: GoalDocuments,
        breakdown: Breakdown,
        commands: MachineCommandHandling,
        probation: Probation,
        reservation_handling: ReservationHandling,
        life: Life,
        shutdown: GracefulShutdown,
    ) -> None:
        self._software = software
        self._joining = joining
        self._key = keys.machine_heartbeat(life.agent)
        self._goals = goals
        self._supply = supply
        self._flow = flow
        self._cycle = cycle
        self._documents = documents
        self._breakdown = breakdown
        self._commands = commands
        self._probation = probation
        self._reservation_handling = reservation_handling
        self._life, self._shutdown = life, shutdown
        self.status = MachineStatus.IDLE
        self._told: Stock | None = None
        self._told_s = 0.0
        """The stock last reported, and when."""
        self._had_documents = False
        """Whether this life ever had documents; if not, heartbeats omit them."""

    def say(self, now_s: float) -> MachineHeartbeat:
        """Send a heartbeat."""
        breakdown = self._breakdown
        buffers, goods, documents = self._stock(now_s)
        heartbeat = MachineHeartbeat(
            machine=self._life.agent,
            incarnation=self._life.incarnation,
            seq=self._life.count_beat(),
            at_s=now_s,
            status=self.status,
            product=self._cycle.product,
            goals=self._goals.briefs(now_s, self._cycle.goal),
            tasks=tuple(task.brief() for task in self._flow.tasks),
            buffers=buffers,
            goods=goods,
            documents=documents,
            waits=self._flow.sourcing.waits(),
            problem=breakdown.problem,
            about_problem=UNSET if breakdown.about == NOTHING_KNOWN else breakdown.about,
            resettable=breakdown.resettable or UNSET,
            help=breakdown.help or UNSET,
            out_of_service=self._commands.service.out or UNSET,
            speed_frac=UNSET if self._goals.speed_frac == 1.0 else self._goals.speed_frac,
            software=self._software,
            draining=self._shutdown.begun,
            probation=self._probation.brief(),
            joining=self._joining,
            people=self._commands.people or UNSET,
            doubts=self._flow.visits.doubts.told(),
            awaits=self._reservation_handling.awaited(now_s),
            dock_wait=self._flow.door.wait(now_s),
        )
        self._life.publish(self._key, heartbeat)
        return heartbeat

    def _stock(self, now_s: float) -> tuple[_Levels, _Levels, tuple[DocumentBrief, ...] | UnsetType]:
        """The stock, when the next heartbeat has to report it."""
        documents = self._documents.briefs()
        self._had_documents |= bool(documents)
        stock = self._supply.levels(), self._flow.goods.levels(), documents
        # Half an interval of tolerance.
        if stock == self._told and now_s - self._told_s < STOCK_EVERY_S - WORKING_INTERVAL_S / 2:
            return UNSET, UNSET, UNSET
        self._told, self._told_s = stock, now_s
        return stock if self._had_documents else (stock[0], stock[1], UNSET)

    def update(self, now_s: float) -> None:
        """Update the status, and report a change."""
        status, reason = self._present()
        if status is self.status:
            return
        self.status = status
        fact = MachineStatusChanged(status=status, product=self._cycle.product, reason=reason)
        self._life.record(fact)
        self._life.beat_soon(now_s)

    def _present(self) -> tuple[MachineStatus, str]:
        if self._breakdown.problem:
            return MachineStatus.ERROR, self._breakdown.problem
        if self._cycle.product:
            return MachineStatus.PRODUCING, ""
        if self._cycle.rests:
            return MachineStatus.RESTING, ""
        if not self._goals.unfinished:
            return MachineStatus.IDLE, ""
        if self._flow.goods.full or self._cycle.blocked:
            return MachineStatus.BLOCKED, "the goods are not fetched"
        return (
            MachineStatus.STARVED,
            self._documents.hindrance() or self._flow.sourcing.told() or "material is missing",
        )


def introduction(spec: MachineSpec) -> JoiningMachine:
    """The data of a machine that others' plant files lack."""
    return JoiningMachine(
        name=spec.name,
        station=spec.station,
        node=spec.node,
        x_m=spec.box.x_m,
        y_m=spec.box.y_m,
        width_m=spec.box.width_m,
        depth_m=spec.box.depth_m,
        makes=tuple(Making(making.product, making.cycle_s) for making in spec.makes),
        goods_capacity=spec.goods_capacity,
    )
