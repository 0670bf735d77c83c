"""The sources of a coordinator's material: it has stations of storages set it aside before it hires a vehicle.

    ASKING --all have answered, one has it--> announced, from those that have it --contracted--> one of them
       |                                          ^
       +--nobody has it--> WAITING --its turn-----+

No vehicle is hired before a station has set the material aside, and the machine reports what it waits for. It is in
the queue of every station that it has asked. The first station with the material is taken. What others set aside is
given back, at the latest when a vehicle has chosen its source. A reservation is renewed until the load is on board.

A silent station counts as one without material: without it the dock would not open. A carrier that waits there is
not to blame.

All stations are asked regularly, even after an answer: reservations and queue places lapse unless they are renewed.
This is not a retransmission (`runtime.retransmission`), although it also makes up for a lost message.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import cast

from msgspec.structs import replace

from dray.messages import MaterialWait, Phase, StockAsked, StockFreed, StockReserved, StockShort, Transport
from dray.plant import Plant
from dray.protocol.contract_net.task import ClosedTask, OpenTask
from dray.protocol.runtime.life import Change, Life

SOURCE = "source"
RENEW = "renew"

ANSWER_S = 2.0
"""Time to wait for all stations before a task is announced from those that have answered (s)."""

AGAIN_S = 10.0
"""Interval of requests while waiting for material (s): a silent station may be back."""

RENEW_S = 60.0
"""Interval of renewals until the load is on board (s): most loads are fetched before the first."""

LIVES_S = 10.0
"""Interval for asking a station where a carrier stands too long (s)."""

ASKED_MAX = 4
"""Maximum storages asked for one task, the closest: as many as a vehicle compares chargers."""

PARTS_ASKED_MAX = 8
"""Maximum places asked for parts, which machines have, too."""

PART_WAITS_S = 25.0
"""Wait for parts after which a smaller quantity is taken (s): no more may come. Not while other loads of it wait for a
carrier: vehicles are few then, and each would fetch only a piece or two."""

_NOT_YET_FETCHED = frozenset({Phase.APPROACHING, Phase.LOADING})


class Need:
    """Needed material for which no vehicle is hired yet.

    Attributes:
        task: the id of its future transport.
        work: its work, with all storages that are asked.
        deadline_s: when it should be there.
        since_s: time of the first request.
        waits: whether it was not available at first.
    """

    __slots__ = ("answered", "deadline_s", "reserved", "short", "since_s", "task", "waits", "work")

    def __init__(self, task: str, work: Transport, deadline_s: float, since_s: float) -> None:
        self.task, self.work, self.deadline_s, self.since_s = task, work, deadline_s, since_s
        self.reserved: dict[str, None] = {}
        """Stations that have set it aside."""
        self.short: dict[str, int] = {}
        """Stations that are short of it, with the pieces that they have."""
        self.answered: dict[str, None] = {}
        """Stations that have answered the last request."""
        self.waits = False

    @property
    def silent(self) -> tuple[str, ...]:
        """Stations that have not answered."""
        return tuple(
            each for each in self.work.sources if each not in self.reserved and each not in self.short
        )

    def wait(self) -> MaterialWait:
        """The need's entry in the heartbeat."""
        return MaterialWait(
            item=self.work.item,
            quantity=self.work.quantity,
            short=tuple(self.short),
            silent=self.silent,
            since_s=self.since_s,
        )


@dataclass(frozen=True, slots=True)
class MaterialReserved(Change):
    """The material of a need is set aside in all of its sources: it can be fetched."""

    need: Need


@dataclass(frozen=True, slots=True)
class MaterialGone(Change):
    """No station has the material of an open task without a carrier."""

    task: OpenTask


@dataclass(frozen=True, slots=True)
class NeedReduced(Change):
    """A smaller load is to come than was requested."""

    before: Transport
    after: Transport


class Sourcing:
    """The material that one coordinator has requested.

    Args:
        place: the coordinator's place.
        plant: its storages.
        life: the agent's life; alarms are named ``(SOURCE, task)`` and ``(RENEW, task)``.
        tasks: the coordinator's open tasks, by id.
        closed: its ended tasks, by id.

    Attributes:
        alarms: handlers of this class's alarms, called with (task, now_s).
    """

    def __init__(
        self,
        place: str,
        plant: Plant,
        tasks: Mapping[str, OpenTask],
        closed: Mapping[str, ClosedTask],
        life: Life,
    ) -> None:
        self._place = place
        self._plant = plant
        self._life = life
        self._tasks, self._closed = tasks, closed
        self._needs: dict[str, Need] = {}
        self._held: dict[str, dict[str, None]] = {}
        """By open task: the stations that have set its material aside, as far as is known."""
        self._asked_s: dict[str, float] = {}
        """By station: the last request and the last answer."""
        self._heard_s: dict[str, float] = {}
        self.alarms: dict[str, Callable[[str, float], None]] = {SOURCE: self._ask_again, RENEW: self._renew}

    def __iter__(self) -> Iterator[Need]:
        """Needs that are not announced yet, the oldest first."""
        return iter(self._needs.values())

    def waits(self) -> tuple[MaterialWait, ...]:
        """For the heartbeat: needs whose material is not available."""
        return tuple(need.wait() for need in self if need.waits)

    def told(self) -> str:
        """The same in words; empty if no need waits."""
        by_item = {wait.item: wait.told(wait.item) for wait in self.waits()}
        return "waits for " + ", ".join(by_item.values()) if by_item else ""

    def holds(self, task: str, station: str) -> bool:
        """Whether a station has set material aside for an open task, as far as is known."""
        return station in self._held.get(task, ())

    def answers(self, task: OpenTask, now_s: float) -> bool:
        """Whether the station of an open task's source has answered lately; if not, it is asked."""
        station = task.contract.source
        if not _is_material(task, self._place) or station not in _work(task).sources:
            return True
        if now_s - self._heard_s.get(station, -LIVES_S) < LIVES_S:
            return True
        if now_s - self._asked_s.get(station, -LIVES_S) >= LIVES_S:
            self._asked_s[station] = now_s
            self._ask(task.id, task.epoch, _work(task), (station,))
        return False

    # --- before a vehicle is hired ---

    def seek(self, task: str, work: Transport, deadline_s: float, now_s: float) -> None:
        """Have material set aside for a task that is to be announced."""
        node = self._plant.node_of(self._place)
        most = PARTS_ASKED_MAX if work.item in self._plant.parts else ASKED_MAX
        near = self._plant.closest(node, work.sources, most)
        work = replace(work, sources=tuple(each for each in work.sources if each in near))
        need = self._needs[task] = Need(task, work, deadline_s, now_s)
        self._ask(need.task, 1, need.work, need.work.sources)
        self._life.alarm((SOURCE, task), now_s + ANSWER_S)

    def drop(self, need: Need) -> None:
        """Drop a need."""
        del self._needs[need.task]
        self._life.cancel((SOURCE, need.task))
        self._free(need.task, need.work.sources)

    def on_reserved(self, sender: str, message: StockReserved, now_s: float) -> None:
        self._note_heard(sender, now_s)
        need = self._needs.get(message.task)
        if need is not None and sender in need.work.sources:
            need.short.pop(sender, None)
            need.reserved[sender] = need.answered[sender] = None
            self._settle(need, now_s)
            return
        task = self._tasks.get(message.task)
        if task is not None and sender in _sources(task):
            if message.epoch < task.epoch:
                # It asks for the load of a carrier that was replaced. What that one has done is unknown.
                self._life.send(sender, StockFreed(message.task, fetched=True, epoch=message.epoch))
            else:
                self._hold(task, sender)
        else:
            fetched = self._may_be_fetched(message.task, message.epoch)
            known = fetched and self._was_brought(message.task, message.epoch)
            self._life.send(sender, StockFreed(message.task, fetched=fetched, known=known))

    def on_short(self, sender: str, message: StockShort, now_s: float) -> None:
        self._note_heard(sender, now_s)
        need = self._needs.get(message.task)
        if need is not None and sender in need.work.sources:
            need.reserved.pop(sender, None)
            need.short[sender], need.answered[sender] = message.free, None
            self._settle(need, now_s)
            return
        task = self._tasks.get(message.task)
        if task is None or sender not in _sources(task):
            self._life.ignore("a shortage of material that was not asked for there")
            return
        held = self._held.get(task.id, {})
        held.pop(sender, None)
        if not held and not task.primary and not task.is_held:
            self._life.note(MaterialGone(task))

    # --- with a carrier ---

    def follow(self, task: OpenTask, now_s: float) -> None:
        """An open task has a carrier, has lost it, or comes from an earlier life."""
        if not _is_material(task, self._place):
            return
        if task.primary:
            if task.contract.source:
                # Sources that were not chosen.
                others = [each for each in self._held.get(task.id, ()) if each != task.contract.source]
                self._free(task.id, others)
                self._held[task.id] = (
                    {task.contract.source: None} if self.holds(task.id, task.contract.source) else {}
                )
        else:
            self._held.pop(task.id, None)
        if not self._held.get(task.id) and not _was_fetched(task):
            # No station has set material aside for this epoch, as far as is known.
            self._ask(task.id, task.epoch, _work(task), _sources(task))
        self._life.alarm((RENEW, task.id), now_s + RENEW_S)

    def on_task_closed(self, task: OpenTask, *, fetched: bool) -> None:
        """A task has ended: give back what was set aside and not fetched."""
        held = self._held.pop(task.id, None)
        self._life.cancel((RENEW, task.id))
        if _is_material(task, self._place) and not fetched:
            # A carrier may have it now or from an earlier epoch: a station that has asked is told.
            carried = bool(task.primary) or task.epoch > 1
            self._free(task.id, tuple(held or _sources(task)), fetched=carried)

    # --- internals ---

    def _note_heard(self, station: str, now_s: float) -> None:
        if self._plant.has_place(station):
            self._heard_s[station] = now_s

    def _settle(self, need: Need, now_s: float) -> None:
        """Announce a need that can be fetched, after all answers or the answer timeout."""
        if need.silent and not need.waits:
            return
        if not need.reserved:
            if not need.waits:
                need.waits = True
                self._life.alarm((SOURCE, need.task), now_s + AGAIN_S)
                self._life.beat_soon(now_s)
            return
        del self._needs[need.task]
        self._life.cancel((SOURCE, need.task))
        # Cancel our request at stations that are short or silent.
        self._free(need.task, (*need.short, *need.silent))
        there = tuple(each for each in need.work.sources if each in need.reserved)
        need.work = replace(need.work, sources=there)
        self._held[need.task] = dict.fromkeys(there)
        self._life.alarm((RENEW, need.task), now_s + RENEW_S)
        self._life.note(MaterialReserved(need))

    def _ask_again(self, task_id: str, now_s: float) -> None:
        need = self._needs.get(task_id)
        if need is None:
            return
        if not need.waits:
            need.waits = True
            self._life.beat_soon(now_s)
        self._settle(need, now_s)
        if task_id in self._needs:
            # A station that did not answer the last request may be down.
            need.short = {each: free for each, free in need.short.items() if each in need.answered}
            need.answered.clear()
            self._take_less(need, now_s)
            self._ask(need.task, 1, need.work, need.work.sources)
            self._life.alarm((SOURCE, task_id), now_s + AGAIN_S)

    def _take_less(self, need: Need, now_s: float) -> None:
        """Reduce a need for parts to the largest available quantity if no station has enough."""
        there = max(need.short.values(), default=0)
        is_part = need.work.item in self._plant.parts
        if not is_part or not 0 < there < need.work.quantity or now_s < need.since_s + PART_WAITS_S:
            return
        if self._wait_for_carrier(need.work.item):
            return
        self._free(need.task, need.work.sources)
        before, need.work = need.work, replace(need.work, quantity=there)
        need.short.clear()
        self._life.note(NeedReduced(before, need.work))

    def _wait_for_carrier(self, item: str) -> bool:
        """Whether an open task with this item has no carrier yet."""
        tasks = map(self._tasks.get, self._held)
        return any(task is not None and _work(task).item == item and not task.primary for task in tasks)

    def _may_be_fetched(self, task: str, epoch: int) -> bool:
        """Whether a load may have been fetched in an epoch; excluded only if no carrier was bound in it."""
        closed = self._closed.get(task)
        return closed is None or epoch != closed.epoch or bool(closed.carrier)

    def _was_brought(self, task: str, epoch: int) -> bool:
        """Whether a load was delivered in an epoch."""
        closed = self._closed.get(task)
        return closed is not None and (closed.epoch, closed.outcome) == (epoch, "delivered")

    def _renew(self, task_id: str, now_s: float) -> None:
        task = self._tasks.get(task_id)
        if task is None or _was_fetched(task) or not _is_material(task, self._place):
            return
        self._ask(task_id, task.epoch, _work(task), tuple(self._held.get(task_id) or _sources(task)))
        self._life.alarm((RENEW, task_id), now_s + RENEW_S)

    def _hold(self, task: OpenTask, station: str) -> None:
        if task.primary and task.contract.source not in ("", station):
            self._free(task.id, (station,))
        else:
            self._held.setdefault(task.id, {})[station] = None

    def _ask(self, task: str, epoch: int, work: Transport, stations: tuple[str, ...]) -> None:
        asked = StockAsked(task=task, epoch=epoch, item=work.item, quantity=work.quantity)
        for station in stations:
            # A place that knows a transport from its carrier alone may know no other source than itself.
            if station != self._place:
                self._life.send(station, asked)

    def _free(self, task: str, stations: tuple[str, ...] | list[str], *, fetched: bool = False) -> None:
        for station in stations:
            self._life.send(station, StockFreed(task, fetched=fetched))


def _is_material(task: OpenTask, place: str) -> bool:
    """Whether a place gives the load, and not a person who hands over a failed vehicle's load."""
    work = task.work
    return isinstance(work, Transport) and work.destination == place and not work.handed_at


def _work(task: OpenTask) -> Transport:
    return cast(Transport, task.work)


def _sources(task: OpenTask) -> tuple[str, ...]:
    """The known sources of a task's load."""
    return (task.contract.source,) if task.contract.source else _work(task).sources


def _was_fetched(task: OpenTask) -> bool:
    """Whether the load is on board by its carrier's last report: no source is needed any more."""
    return task.contract.phase is not None and task.contract.phase not in _NOT_YET_FETCHED
