"""The spells of vehicles and machines: what each did from when to when, by the stream's views."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

from dray.gateway.live.frames import Delta, Snapshot
from dray.gateway.live.views import AtvView, MachineView, TaskView, WaitView
from dray.messages.heartbeat import GOODS_ABOARD
from dray.store.replay.spells import AtvDoing, MachineDoing, Spell

ENDED_MOST = 20_000
"""Maximum unwritten spells: half an hour of 1,000 vehicles. Beyond that the oldest are dropped."""

LONGEST_S = 3600.0
"""Maximum wall seconds of a spell; longer activities are split. A reader of a shift need not look further
back, and activities since yesterday are in SQL too."""

OF_ATVS: dict[str, AtvDoing] = {
    "idle": "idle",
    "charging": "charges",
    "stopped": "stopped",
    "error": "blocked",
}
OF_MACHINES: dict[str, MachineDoing] = {
    "idle": "idle",
    "producing": "makes",
    "starved": "starves",
    "blocked": "blocked",
    "error": "broken",
    "resting": "rests",
}


class Doing(NamedTuple):
    """The activity of an agent."""

    doing: AtvDoing | MachineDoing
    task: str = ""
    item: str = ""
    source: str = ""
    destination: str = ""
    other: str = ""


@dataclass(slots=True)
class _Last:
    """The last state heard of an agent."""

    doing: Doing
    since_at_s: float
    seen_at_s: float
    lost_after_s: float
    """Real seconds."""
    is_lost: bool = False


class SpellKeeper:
    """Follows the stream's frames.

    Args:
        speed: factory seconds per real second.
    """

    def __init__(self, speed: float) -> None:
        self._speed = speed
        self._last: dict[str, _Last] = {}
        """By agent; bounded because only admitted agents are shown."""
        self._atvs: dict[str, AtvView] = {}
        self._tasks: dict[str, TaskView] = {}
        self._waits: dict[str, WaitView] = {}
        self._ended: list[Spell] = []

    def follow(self, told: Delta | Snapshot) -> None:
        """Take in a frame."""
        for task in told.tasks:
            self._tasks[task.id] = task
        for wait in told.waits:
            self._waits[wait.id] = wait
        if isinstance(told, Delta):
            self._forget(told.gone, told.at_s)
        for atv in told.atvs:
            self._atvs[atv.id] = atv
            self._note_atv(atv, atv.seen_at_s)
        for wait in told.waits:
            if wait.id in self._atvs:
                self._note_atv(self._atvs[wait.id], told.at_s)
        for machine in told.machines:
            self._note(machine, self._of_machine(machine), machine.seen_at_s)
        self._find_lost(told.at_s)

    def _forget(self, gone: Iterable[str], at_s: float) -> None:
        for name in gone:
            kind, _, entity = name.partition(":")
            if kind == "task":
                self._tasks.pop(entity, None)
            elif kind == "wait":
                self._waits.pop(entity, None)
                if entity in self._atvs:
                    self._note_atv(self._atvs[entity], at_s)
            elif kind in ("atv", "machine"):
                self._atvs.pop(entity, None)
                self._end(entity, at_s)

    def _find_lost(self, now_s: float) -> None:
        for agent, last in self._last.items():
            if not last.is_lost and now_s - last.seen_at_s > last.lost_after_s:
                self._close(agent, last, last.seen_at_s)
                last.is_lost, last.since_at_s = True, max(last.seen_at_s, last.since_at_s)
            while now_s - last.since_at_s > LONGEST_S:
                self._close(agent, last, last.since_at_s + LONGEST_S)
                last.since_at_s += LONGEST_S

    def take_ended(self) -> list[Spell]:
        """Spells that ended since the last call."""
        ended, self._ended = self._ended, []
        return ended

    def under_way(self, now_s: float) -> list[Spell]:
        """Present spells up to now, and ended ones that were not taken."""
        now = [_spell(agent, last, max(now_s, last.since_at_s)) for agent, last in self._last.items()]
        return self._ended + now

    def give_back(self, spells: list[Spell]) -> None:
        """Put back spells that could not be written."""
        self._ended = (spells + self._ended)[-ENDED_MOST:]

    def end_all(self, at_s: float) -> None:
        """End all present spells at the end of recording."""
        for agent in list(self._last):
            self._end(agent, at_s)

    def _note_atv(self, atv: AtvView, at_s: float) -> None:
        self._note(atv, self._of_atv(atv), at_s)

    def _note(self, view: AtvView | MachineView, doing: Doing, at_s: float) -> None:
        last = self._last.get(view.id)
        lost_after_s = view.silence.lost_after_s / self._speed
        if last is None:
            self._last[view.id] = _Last(doing, at_s, view.seen_at_s, lost_after_s)
            return
        heard = view.seen_at_s > last.seen_at_s
        if (last.is_lost and heard) or (not last.is_lost and doing != last.doing):
            at_s = max(at_s, last.since_at_s)
            self._close(view.id, last, at_s)
            last.since_at_s, last.is_lost = at_s, False
        last.doing, last.lost_after_s = doing, lost_after_s
        last.seen_at_s = max(last.seen_at_s, view.seen_at_s)

    def _end(self, agent: str, at_s: float) -> None:
        last = self._last.pop(agent, None)
        if last is not None:
            self._close(agent, last, max(at_s, last.since_at_s))

    def _close(self, agent: str, last: _Last, at_s: float) -> None:
        if at_s > last.since_at_s:
            self._ended.append(_spell(agent, last, at_s))
            del self._ended[:-ENDED_MOST]

    def _of_atv(self, atv: AtvView) -> Doing:
        if atv.removal is not None or atv.out_of_service is not None:
            return Doing("out")
        if atv.status in ("stopped", "error"):
            problem = "" if atv.about_problem is None else atv.about_problem.kind
            return Doing(OF_ATVS[atv.status], other=problem)
        wait = self._waits.get(atv.id)
        brief = atv.task
        if brief is None:
            if wait is not None and atv.status == "working":
                return Doing("waits", other=_waits_for(wait))
            watched = self._tasks.get(atv.watches[0].task) if atv.watches else None
            return Doing(OF_ATVS.get(atv.status, "idle"), other="" if watched is None else watched.primary)
        task = self._tasks.get(brief.task)
        source, destination = ("", "") if task is None else (task.source, task.destination)
        aboard = brief.phase in GOODS_ABOARD
        doing: AtvDoing = "waits" if wait is not None else "carries" if aboard else "fetches"
        other = "" if wait is None else _waits_for(wait)
        return Doing(doing, brief.task, brief.item, source, destination, other)

    def _of_machine(self, machine: MachineView) -> Doing:
        if machine.out_of_service is not None:
            return Doing("out")
        other = ""
        if machine.status == "error" and machine.about_problem is not None:
            other = machine.about_problem.kind
        elif machine.status == "starved":
            other = next((each.item for each in machine.buffers if each.level == 0), "")
        return Doing(OF_MACHINES[machine.status], item=machine.product, other=other)


def _waits_for(wait: WaitView) -> str:
    return wait.cause.chain[0] if wait.cause.chain else wait.place


def _spell(agent: str, last: _Last, until_s: float) -> Spell:
    if last.is_lost:
        return Spell(agent=agent, doing="silent", from_at_s=last.since_at_s, until_at_s=until_s)
    return Spell(agent=agent, from_at_s=last.since_at_s, until_at_s=until_s, **last.doing._asdict())
