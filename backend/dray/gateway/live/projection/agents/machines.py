"""Machines as panels see them: the last heartbeat of each."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator

from msgspec import UNSET
from msgspec.structs import asdict

from dray.gateway.live.projection.agents.asked import help_view, out_view, problem_view
from dray.gateway.live.projection.agents.atvs import clock_of, joining_max, plain, probation_of
from dray.gateway.live.projection.agents.loads import doubts_of, loads_of
from dray.gateway.live.projection.agents.outsiders import Outsiders
from dray.gateway.live.projection.agents.silence import Silence
from dray.gateway.live.projection.changes import Changes
from dray.gateway.live.projection.figures.time_use import TimeUse
from dray.gateway.live.projection.materials import Materials
from dray.gateway.live.projection.site import Site
from dray.gateway.live.reasons import trouble_of
from dray.gateway.live.views import BufferView, DocumentView, GoalView, MachineView, OpenTaskView
from dray.messages import (
    BufferLevel,
    DocumentBrief,
    GoalBrief,
    MachineHeartbeat,
    MachineStatus,
    TaskBrief,
)
from dray.messages.heartbeat_stock import with_stock
from dray.messages.overtaken import LatestNumbers
from dray.store.history.clocks import Clocks, ToWall

MAKING, STARVED, IDLE, BROKEN, DOWN, RESTING = "making", "starved", "idle", "broken", "down", "resting"

DOINGS = (MAKING, STARVED, IDLE, BROKEN, DOWN, RESTING)
"""What a machine may do. A machine in error is broken with a goal, and down without one. Rest by working time
does not count as other time."""

WITH_GOAL = (MAKING, STARVED, BROKEN)


class Machines:
    """The machines.

    Args:
        site: knows the machines' names.
        to_wall_s: plant clock to wall clock.
        outsiders: the agents that are shut out.
        clocks: of all agents.
        silence: of all agents.
        materials: knows the materials' names.
    """

    def __init__(
        self,
        site: Site,
        to_wall_s: ToWall,
        outsiders: Outsiders,
        clocks: Clocks,
        silence: Silence,
        materials: Materials,
    ) -> None:
        self._materials = materials
        self._outsiders = outsiders
        self._clocks, self._silence = clocks, silence
        self._known = frozenset(site.plant.machines)
        """Machines in the plant file."""
        self.strangers = 0
        """Heartbeats ignored because their machines are not in the plant file and too many have joined."""
        self._joined = 0
        self._site = site
        self._to_wall_s = to_wall_s
        self._last: dict[str, MachineHeartbeat] = {}
        self._newest: LatestNumbers[str] = LatestNumbers()
        self._since_s: dict[str, float] = {}
        """Per machine, the time since which it has had its status (plant clock)."""
        self.use = TimeUse(DOINGS)
        self.changes = Changes("machine")
        self.due_of: Callable[[str], float | None] = lambda _goal: None
        """The due time of a goal's order (wall clock); None where it is not known."""
        self.order_of: Callable[[str], tuple[str, str]] = lambda _goal: ("", "")
        """The id of a goal's order, and the order's name for people."""
        self.name_of: Callable[[str], str] = lambda item: item
        """The name of a material or product."""
        self.by_status: Counter[str] = Counter()

    def fold(self, heartbeat: MachineHeartbeat, now_s: float) -> bool:
        """Take a heartbeat in, which came at this time of the plant's clock.

        Returns:
            False when it is older than the last one, or exceeds the number of machines that may join.
        """
        last = self._last.get(heartbeat.machine)
        if last is None:
            if heartbeat.machine not in self._known:
                if self._joined >= joining_max(len(self._known)):
                    self.strangers += 1
                    return False
                self._joined += 1
        if not self._newest.takes(heartbeat.machine, (heartbeat.incarnation, heartbeat.seq), now_s):
            return False
        if last is None or last.status is not heartbeat.status:
            self.by_status[heartbeat.status.value] += 1
            if last is not None:
                self.by_status[last.status.value] -= 1
        heartbeat = with_stock(heartbeat, last)
        if last is None or last.status is not heartbeat.status:
            self._since_s[heartbeat.machine] = heartbeat.at_s
        self.use.tell(heartbeat.machine, doing(heartbeat), heartbeat.at_s)
        self._last[heartbeat.machine] = heartbeat
        self.changes.mark(heartbeat.machine)
        return True

    def product_of(self, goal: str) -> str:
        """The product of a goal, by its machine's heartbeat; empty where no machine makes it."""
        made = (each for heartbeat in self._last.values() for each in heartbeat.goals if each.goal == goal)
        brief = next(made, None)
        return "" if brief is None else brief.product

    def starved_frac(self, now_s: float) -> float | None:
        """Fraction of last hour's time with a goal in which material was missing; None without such time.

        Args:
            now_s: plant clock.
        """
        with_goal_s = sum(self.use.hour_s(each, now_s) for each in WITH_GOAL)
        return self.use.hour_s(STARVED, now_s) / with_goal_s if with_goal_s > 0 else None

    def heartbeats(self) -> Iterator[tuple[MachineHeartbeat, float]]:
        """The last one of each machine, and since when it has had that status (plant clock)."""
        return ((heartbeat, self._since_s[machine]) for machine, heartbeat in self._last.items())

    def mark(self, agents: Iterable[str]) -> None:
        """Mark these machines as changed, if they were heard."""
        for agent in agents:
            if agent in self._last:
                self.changes.mark(agent)

    def view(self, machine: str) -> MachineView | None:
        """One machine, or None when it was never heard."""
        heartbeat = self._last.get(machine)
        return None if heartbeat is None else self._view(heartbeat)

    def views(self) -> tuple[MachineView, ...]:
        """All of them, by id."""
        return tuple(self._view(self._last[machine]) for machine in sorted(self._last))

    def take_changed(self) -> tuple[MachineView, ...]:
        """Those that have changed since the last call."""
        return tuple(self._view(self._last[machine]) for machine in self.changes.take_changed())

    def _view(self, heartbeat: MachineHeartbeat) -> MachineView:
        spec = self._site.plant.machines.get(heartbeat.machine)
        return MachineView(
            id=heartbeat.machine,
            name=heartbeat.machine if spec is None else spec.name,
            status=plain(heartbeat.status),
            product=heartbeat.product,
            goals=tuple(self._goal(goal) for goal in heartbeat.goals),
            tasks=tuple(self._task(task) for task in heartbeat.tasks),
            buffers=tuple(_buffer(level) for level in heartbeat.buffers or ()),
            goods=tuple(_buffer(level) for level in heartbeat.goods or ()),
            documents=tuple(_document(brief) for brief in heartbeat.documents or ()),
            problem=heartbeat.problem,
            about_problem=None if heartbeat.about_problem is UNSET else problem_view(heartbeat.about_problem),
            resettable=heartbeat.resettable is True,
            help=None if heartbeat.help is UNSET else help_view(heartbeat.help, self._to_wall_s),
            out_of_service=(
                None
                if heartbeat.out_of_service is UNSET
                else out_view(heartbeat.out_of_service, self._to_wall_s)
            ),
            speed_frac=1.0 if heartbeat.speed_frac is UNSET else heartbeat.speed_frac,
            since_at_s=self._to_wall_s(self._since_s[heartbeat.machine]),
            waits=self._materials.cause(heartbeat.waits),
            software=heartbeat.software,
            draining=heartbeat.draining,
            probation=probation_of(heartbeat),
            unconfirmed=loads_of(heartbeat.people),
            doubts=doubts_of(heartbeat.doubts, self.name_of),
            shut_out=self._outsiders.view(heartbeat.machine),
            clock=clock_of(self._clocks, heartbeat.machine),
            seen_at_s=self._to_wall_s(heartbeat.at_s),
            silence=self._silence.view(heartbeat.machine, heartbeat),
        )

    def _goal(self, goal: GoalBrief) -> GoalView:
        return GoalView(
            goal=goal.goal,
            product=goal.product,
            quantity=goal.quantity,
            made=goal.made,
            to_begin=max(0, goal.quantity - goal.made) if goal.to_begin is UNSET else goal.to_begin,
            delivered=goal.delivered,
            deadline_at_s=None if goal.deadline_s is UNSET else self._to_wall_s(goal.deadline_s),
            order_due_at_s=self.due_of(goal.goal),
            order_name=self.order_of(goal.goal)[1],
            offered=goal.offered is True,
        )

    def _task(self, task: TaskBrief) -> OpenTaskView:
        return OpenTaskView(
            task=task.task,
            epoch=task.epoch,
            item=task.item,
            quantity=task.quantity,
            source=task.source,
            destination=task.destination,
            deadline_at_s=self._to_wall_s(task.deadline_s),
            primary=task.primary,
            secondary=task.secondary,
            round=task.round,
            trouble=trouble_of(task),
        )


def doing(heartbeat: MachineHeartbeat) -> str:
    """What a machine does."""
    at_work = heartbeat.goals and heartbeat.status is not MachineStatus.IDLE
    match heartbeat.status:
        case MachineStatus.ERROR:
            return BROKEN if at_work else DOWN
        case MachineStatus.RESTING:
            return RESTING
        case MachineStatus.STARVED if at_work:
            return STARVED
    return MAKING if at_work else IDLE


def _buffer(level: BufferLevel) -> BufferView:
    return BufferView(
        item=level.item,
        level=level.level,
        capacity=level.capacity,
        reorder_point=level.reorder_point,
        on_order=level.on_order,
        spare=level.spare,
    )


def _document(brief: DocumentBrief) -> DocumentView:
    return DocumentView(
        product=brief.product, state=plain(brief.state), detail=brief.detail, **asdict(brief.document)
    )
