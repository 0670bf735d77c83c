"""Where a coordinator gets what is to be brought to it: it asks the stations of storages to set it aside before it hires anybody.

    ASKING --all have answered, one has it--> announced, from those that have it --contracted--> one of them
       |                                          ^
       +--nobody has it--> WAITING --its turn-----+

Until a station has set the material aside nobody is hired for it, and the machine tells what it waits for. It is in the
queue of every station that it has asked. The first that has it is taken; what others set aside is given back, at
the latest when a vehicle has chosen where to fetch it. A reservation is renewed until the load is on board.

A station that does not answer is one that has nothing: without it the dock would not open. A carrier that stands before it
meanwhile is not to blame.

All stations are asked regularly, those that have answered too: what is set aside, and a place in a queue, lapse unless they are
renewed. This is no repetition of an unanswered message (`runtime.retransmission`), although a lost one is made good by it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import cast

from msgspec.structs import replace

from dray.messages import MaterialWait, Phase, StockAsked, StockFreed, StockReserved, StockShort, Transport
from dray.plant import Plant
from dray.protocol.contract_net.task import OpenTask
from dray.protocol.runtime.life import Life

SOURCE = "source"
RENEW = "renew"

ANSWER_S = 2.0
"""So long all stations are waited for before a task is announced from those that have answered."""

AGAIN_S = 10.0
"""Who waits for material asks again so often: a station that was silent may be back."""

RENEW_S = 60.0
"""A reservation is renewed so often, until the load is on board: most are fetched before the first time."""

LIVES_S = 10.0
"""A station at which a carrier stands for too long is asked so often whether it is there."""

ASKED_MAX = 4
"""Storages that are asked for one task, the closest: as many as a vehicle compares chargers."""

PARTS_ASKED_MAX = 8
"""For parts, which their machines have, too."""

PART_WAITS_S = 25.0
"""Who has waited so long for parts takes as many as lie somewhere: no more may come there. Not while others of them wait
for a carrier: vehicles are few then, and each would go for a piece or two."""

_NOT_YET_FETCHED = frozenset({Phase.APPROACHING, Phase.LOADING})


class Need:
    """Material that is needed, and for which nobody is hired yet.

    Attributes:
        task: the name that its transport will have.
        work: from all storages that are asked.
        deadline_s: when it should be there.
        since_s: when it was asked for first.
        waits: it was not to be had when it was asked for first.
    """

    __slots__ = ("answered", "deadline_s", "reserved", "short", "since_s", "task", "waits", "work")

    def __init__(self, task: str, work: Transport, deadline_s: float, since_s: float) -> None:
        self.task, self.work, self.deadline_s, self.since_s = task, work, deadline_s, since_s
        self.reserved: dict[str, None] = {}
        """Stations that have set it aside."""
        self.short: dict[str, int] = {}
        """Stations that have said that they cannot, with the pieces that they could."""
        self.answered: dict[str, None] = {}
        """Stations that have answered since they were asked last."""
        self.waits = False

    @property
    def silent(self) -> tuple[str, ...]:
        """Stations that have not answered."""
        return tuple(
            each for each in self.work.sources if each not in self.reserved and each not in self.short
        )

    def wait(self) -> MaterialWait:
        """What the heartbeat tells of it."""
        return MaterialWait(
            item=self.work.item,
            quantity=self.work.quantity,
            short=tuple(self.short),
            silent=self.silent,
            since_s=self.since_s,
        )


class Sourcing:
    """The material that one coordinator has asked for.

    Args:
        place: whose.
        plant: its storages.
        life: its agent's; its alarms are named ``(SOURCE, task)`` and ``(RENEW, task)``.
        announce: called with a need for which material is set aside in all of its sources, and now_s.
        task_of: an open task by its name.
        may_be_fetched: whether the load of a task that is not open was fetched in an epoch, or may have been, for nothing is known of it.
        starve: called with an open task whose material is not there any more, before anybody was hired, and now_s.
        changed: called with now_s when something is waited for.
        resized: called with what was to be brought and what is, when less has to do.

    Attributes:
        alarms: what to call when an alarm of this class has come, with (task, now_s).
    """

    def __init__(
        self,
        place: str,
        plant: Plant,
        life: Life,
        *,
        announce: Callable[[Need, float], None],
        task_of: Callable[[str], OpenTask | None],
        may_be_fetched: Callable[[str, int], bool],
        starve: Callable[[OpenTask, float], None],
        changed: Callable[[float], None],
        resized: Callable[[Transport, Transport], None],
    ) -> None:
        self._place = place
        self._plant = plant
        self._life = life
        self._announce = announce
        self._task_of, self._may_be_fetched = task_of, may_be_fetched
        self._starve = starve
        self._changed = changed
        self._resized = resized
        self._needs: dict[str, Need] = {}
        self._held: dict[str, dict[str, None]] = {}
        """By open task, the stations that have set its material aside, as far as is known."""
        self._asked_s: dict[str, float] = {}
        """By station of the plant, when it was asked last, and when it has answered last."""
        self._heard_s: dict[str, float] = {}
        self.alarms: dict[str, Callable[[str, float], None]] = {SOURCE: self._ask_again, RENEW: self._renew}

    def __iter__(self) -> Iterator[Need]:
        """What is needed and not announced yet, the oldest first."""
        return iter(self._needs.values())

    def waits(self) -> tuple[MaterialWait, ...]:
        """For the heartbeat: what nobody is hired for, because it is not to be had."""
        return tuple(need.wait() for need in self if need.waits)

    def told(self) -> str:
        """The same in words; empty when nothing is waited for."""
        by_item = {wait.item: wait.told(wait.item) for wait in self.waits()}
        return "waits for " + ", ".join(by_item.values()) if by_item else ""

    def holds(self, task: str, station: str) -> bool:
        """Whether a station has set material aside for an open task, as far as is known."""
        return station in self._held.get(task, ())

    def answers(self, task: OpenTask, now_s: float) -> bool:
        """Whether the station has answered lately where an open task's load is fetched; it is asked if it has not."""
        station = task.contract.source
        if not _is_material(task, self._place) or station not in _work(task).sources:
            return True
        if now_s - self._heard_s.get(station, -LIVES_S) < LIVES_S:
            return True
        if now_s - self._asked_s.get(station, -LIVES_S) >= LIVES_S:
            self._asked_s[station] = now_s
            self._ask(task.id, task.epoch, _work(task), (station,))
        return False

    # --- before anybody is hired ---

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
        """It is not needed any more."""
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
        task = self._task_of(message.task)
        if task is not None and sender in _sources(task):
            self._hold(task, sender)
        else:
            fetched = self._may_be_fetched(message.task, message.epoch)
            self._life.send(sender, StockFreed(message.task, fetched=fetched))

    def on_short(self, sender: str, message: StockShort, now_s: float) -> None:
        self._note_heard(sender, now_s)
        need = self._needs.get(message.task)
        if need is not None and sender in need.work.sources:
            need.reserved.pop(sender, None)
            need.short[sender], need.answered[sender] = message.free, None
            self._settle(need, now_s)
            return
        task = self._task_of(message.task)
        if task is None or sender not in _sources(task):
            self._life.ignore("short of what was not asked for")
            return
        held = self._held.get(task.id, {})
        held.pop(sender, None)
        if not held and not task.primary and not task.is_held:
            self._starve(task, now_s)

    # --- while somebody carries it ---

    def follow(self, task: OpenTask, now_s: float) -> None:
        """An open task has got its carrier, has lost it, or is one of an earlier life."""
        if not _is_material(task, self._place):
            return
        if task.primary:
            if task.contract.source:
                # Those that were not chosen.
                others = [each for each in self._held.get(task.id, ()) if each != task.contract.source]
                self._free(task.id, others)
                self._held[task.id] = (
                    {task.contract.source: None} if self.holds(task.id, task.contract.source) else {}
                )
        else:
            self._held.pop(task.id, None)
        if not self._held.get(task.id):
            # Nothing is set aside for this epoch yet, as far as is known.
            self._ask(task.id, task.epoch, _work(task), _sources(task))
        self._life.alarm((RENEW, task.id), now_s + RENEW_S)

    def on_task_closed(self, task: OpenTask, *, fetched: bool) -> None:
        """A task has ended; what was set aside for it and not fetched is given back."""
        held = self._held.pop(task.id, None)
        self._life.cancel((RENEW, task.id))
        if _is_material(task, self._place) and not fetched:
            # A carrier may have it, or may have had it in an earlier epoch: a station that has asked hears that.
            carried = bool(task.primary) or task.epoch > 1
            self._free(task.id, tuple(held or _sources(task)), fetched=carried)

    # --- how it is done ---

    def _note_heard(self, station: str, now_s: float) -> None:
        if self._plant.has_place(station):
            self._heard_s[station] = now_s

    def _settle(self, need: Need, now_s: float) -> None:
        """Announce what can be fetched, when all have answered or were waited for."""
        if need.silent and not need.waits:
            return
        if not need.reserved:
            if not need.waits:
                need.waits = True
                self._life.alarm((SOURCE, need.task), now_s + AGAIN_S)
                self._changed(now_s)
            return
        del self._needs[need.task]
        self._life.cancel((SOURCE, need.task))
        # Whoever has none keeps nobody in its queue who has found another.
        self._free(need.task, (*need.short, *need.silent))
        there = tuple(each for each in need.work.sources if each in need.reserved)
        need.work = replace(need.work, sources=there)
        self._held[need.task] = dict.fromkeys(there)
        self._life.alarm((RENEW, need.task), now_s + RENEW_S)
        self._announce(need, now_s)

    def _ask_again(self, task_id: str, now_s: float) -> None:
        need = self._needs.get(task_id)
        if need is None:
            return
        if not need.waits:
            need.waits = True
            self._changed(now_s)
        self._settle(need, now_s)
        if task_id in self._needs:
            # Whoever has not answered the last time may not be there any more.
            need.short = {each: free for each, free in need.short.items() if each in need.answered}
            need.answered.clear()
            self._take_less(need, now_s)
            self._ask(need.task, 1, need.work, need.work.sources)
            self._life.alarm((SOURCE, task_id), now_s + AGAIN_S)

    def _take_less(self, need: Need, now_s: float) -> None:
        """Of parts that nobody has enough of, as many are asked for as lie somewhere."""
        there = max(need.short.values(), default=0)
        is_part = need.work.item in self._plant.parts
        if not is_part or not 0 < there < need.work.quantity or now_s < need.since_s + PART_WAITS_S:
            return
        if self._wait_for_carrier(need.work.item):
            return
        self._free(need.task, need.work.sources)
        before, need.work = need.work, replace(need.work, quantity=there)
        need.short.clear()
        self._resized(before, need.work)

    def _wait_for_carrier(self, item: str) -> bool:
        """Whether some of it is set aside already, and nobody is hired for it yet."""
        tasks = map(self._task_of, self._held)
        return any(task is not None and _work(task).item == item and not task.primary for task in tasks)

    def _renew(self, task_id: str, now_s: float) -> None:
        task = self._task_of(task_id)
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
            self._life.send(station, asked)

    def _free(self, task: str, stations: tuple[str, ...] | list[str], *, fetched: bool = False) -> None:
        for station in stations:
            self._life.send(station, StockFreed(task, fetched=fetched))


def _is_material(task: OpenTask, place: str) -> bool:
    """Whether a place gives the load: not people, who hand over what a failed vehicle had on board."""
    work = task.work
    return isinstance(work, Transport) and work.destination == place and not work.handed_at


def _work(task: OpenTask) -> Transport:
    return cast(Transport, task.work)


def _sources(task: OpenTask) -> tuple[str, ...]:
    """Where the load of a task is to be fetched, by all that is known."""
    return (task.contract.source,) if task.contract.source else _work(task).sources


def _was_fetched(task: OpenTask) -> bool:
    """Whether the load is on board, as its carrier has told last."""
    last = task.contract.detector.last if task.contract.detector is not None else None
    brief = last.task if last is not None else None
    return brief is not None and brief.task == task.id and brief.phase not in _NOT_YET_FETCHED
