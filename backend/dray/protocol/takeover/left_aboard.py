"""Finished goods on board of a failed vehicle: they wait for a person's decision, and are made again only after it.

Each piece exists once: no other vehicle can carry goods while they are on board, and no machine makes them again
while they may still come. A thing without master data waits likewise; when it is given up, it is sought where it
was fetched. The task keeps its carrier, its epoch and its secondary:

    IN_TRANSIT --its carrier has failed--> STRANDED --heard again--> IN_TRANSIT
                                              |
                                              +-- FETCH_GOODS: a person hands them over at a node. Epoch + 1; the
                                              |   secondary is asked first, then all, to fetch them there
                                              +-- WRITE_OFF, or WRITTEN_OFF_AFTER_S without a decision: they are
                                              made again

The time runs until another vehicle has them on board: a person may promise to hand them over and forget it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol, cast

from msgspec.structs import replace

from dray.messages import CommandRefusal, Reason, StrandedGoods, Transport
from dray.protocol.contract_net.task import OpenTask
from dray.protocol.contract_net.task_state import TaskState
from dray.protocol.runtime.life import Life

WRITTEN_OFF_AFTER_S = 900.0
"""How long goods wait for a decision (s): as long as the system waits for a person who has promised to come."""

GOODS_WAIT = "goods wait"


class Remedies(Protocol):
    """A coordinator's remedies for goods left on board."""

    def pass_on(self, task: OpenTask, reason: Reason, now_s: float) -> None:
        """Ask the secondary of their task to carry it, with a higher epoch; announce it if the secondary declines."""

    def give_up(self, task: OpenTask, now_s: float) -> None:
        """Withdraw their task: they are lost."""


class LeftAboard:
    """The goods of one coordinator that were left on board of failed vehicles.

    Args:
        tasks: its open tasks, by id.
        life: the agent's life; alarms are named ``(GOODS_WAIT, task)``.
        remedies: the coordinator.

    Attributes:
        alarms: handlers of this class's alarms, called with (task, now_s).
    """

    def __init__(self, tasks: Mapping[str, OpenTask], life: Life, remedies: Remedies) -> None:
        self._tasks = tasks
        self._life = life
        self._remedies = remedies
        self.alarms = {GOODS_WAIT: self._end_wait}

    def restore(self, task: OpenTask, goods: StrandedGoods | None) -> None:
        """Continue an earlier life's wait."""
        task.stranded = goods
        if goods is None:
            return
        if task.is_loaded:
            task.states.enter(TaskState.STRANDED)
        self._life.alarm((GOODS_WAIT, task.id), goods.until_s)

    # --- stranding ---

    def strand(self, task: OpenTask, now_s: float) -> None:
        """The carrier of goods has failed. Repeating this is harmless."""
        if task.state is TaskState.STRANDED:
            return
        task.states.enter(TaskState.STRANDED)
        last = task.contract.detector.last if task.contract.detector is not None else None
        node = last.node if last is not None else ""
        task.stranded = StrandedGoods(atv=task.primary, node=node, until_s=now_s + WRITTEN_OFF_AFTER_S)
        self._life.alarm((GOODS_WAIT, task.id), task.stranded.until_s)
        self._life.commit()

    def goes_on(self, task: OpenTask) -> None:
        """Their carrier works again. Repeating this is harmless."""
        if task.state is TaskState.STRANDED:
            task.states.enter(TaskState.IN_TRANSIT)
            task.contract.forgotten_aboard = False
            self.forget(task)

    def note_place(self, task: OpenTask, node: str) -> None:
        """Their carrier moves with them and has forgotten the task: note their new node."""
        if task.stranded is not None and task.stranded.node != node:
            task.stranded = replace(task.stranded, node=node)
            self._life.commit()

    def forget(self, task: OpenTask) -> None:
        """End their wait: a working carrier has them on board, or they are back."""
        was_waiting, task.stranded = task.stranded is not None, None
        self._life.cancel((GOODS_WAIT, task.id))
        if was_waiting:
            self._life.commit()

    # --- people's decisions ---

    def fetch(self, task_id: str, node: str, now_s: float) -> CommandRefusal | None:
        """A person hands them over at a node. Returns the refusal; None when they are fetched there now."""
        task = self._tasks.get(task_id)
        if task is None or task.stranded is None or task.state is not TaskState.STRANDED:
            return CommandRefusal.NOT_STRANDED
        task.stranded = replace(task.stranded, handed_at=node)
        # Their carrier has failed, and a person has taken them off: any other vehicle may fetch them.
        task.work = replace(
            cast(Transport, task.work), sources=(node,), handed_at=node, vehicle="", vehicle_until_s=None
        )
        self._remedies.pass_on(task, Reason.HANDED_BY_PERSON, now_s)
        return None

    def write_off(self, task_id: str, now_s: float) -> CommandRefusal | None:
        """A person writes them off. Returns the refusal; None when they are made again now."""
        task = self._tasks.get(task_id)
        if task is None or task.stranded is None:
            return CommandRefusal.NOT_STRANDED
        self._give_up(task, now_s)
        return None

    def node_of(self, task_id: str) -> str:
        """Their node by their carrier's last heartbeat; empty if unknown."""
        task = self._tasks.get(task_id)
        return "" if task is None or task.stranded is None else task.stranded.node

    # --- internals ---

    def _end_wait(self, task_id: str, now_s: float) -> None:
        task = self._tasks.get(task_id)
        if task is not None and task.stranded is not None:
            self._give_up(task, now_s)

    def _give_up(self, task: OpenTask, now_s: float) -> None:
        self._life.cancel((GOODS_WAIT, task.id))
        self._remedies.give_up(task, now_s)
