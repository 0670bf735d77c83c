"""Knowledge: what an agent knew at a moment, beside what had really happened by then. Pure.

Every agent numbers its own events and reports those later that nobody heard at the time. Its own events about
its transports up to a moment are what it knew. Other agents' events up to that moment are what had happened.
Its next event on the same transport shows when it learnt of that.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import Literal

import msgspec

from dray.gateway.live.frames import PORTION
from dray.gateway.live.plant_picture import PlantPicture
from dray.gateway.live.views import TaskView
from dray.gateway.live.views.base import View
from dray.messages.fact import (
    AnyFact,
    CarrierChanged,
    ContractEnded,
    ContractTaken,
    PhaseEntered,
    PrimarySuspected,
    TaskClosed,
    TookOver,
    WatchLost,
)
from dray.store.history.events import EventRow

TELLING = (
    ContractTaken,
    ContractEnded,
    PhaseEntered,
    TookOver,
    CarrierChanged,
    PrimarySuspected,
    WatchLost,
    TaskClosed,
)
"""Facts about carriers and the progress of transports."""

UPSETTING = (TookOver, CarrierChanged, PrimarySuspected, WatchLost, TaskClosed)
"""Facts from other agents that a contractor must know, because they change its contract."""

TASKS_MOST = 12
"""Maximum tasks per agent and moment: a vehicle carries one and watches some; a machine has some open."""

LOST_KEPT_S = 60.0
"""Wall seconds after a task's end for which an agent that lost it is still asked about it."""

_READ = msgspec.json.Decoder(AnyFact)


class RecordedFactView(View, kw_only=True):
    """One fact about a transport."""

    kind: str
    """The kind of the fact."""
    agent: str
    at_s: float
    role: str = ""
    reason: str = ""
    phase: str = ""
    other: str = ""
    """The agent replaced, suspected or lost, or the new carrier."""
    outcome: str = ""


class KnownView(View, kw_only=True):
    """What an agent knew of one subject, and what had happened."""

    about: Literal["task", "heard", "closures"]
    differs: bool
    task: str = ""
    item: str = ""
    source: str = ""
    destination: str = ""
    role: str = ""
    """The agent's role: primary, secondary, coordinator; empty if it has none any more."""
    knew: RecordedFactView | None = None
    """The agent's own last fact; None without any."""
    happened: RecordedFactView | None = None
    """The last fact from others that it had to know; None without any."""
    learnt_at_s: float | None = None
    """When its first own fact followed what had happened; None if no such fact is kept."""
    heard_at_s: float | None = None
    """When it was last heard before the moment."""
    closures: tuple[str, ...] = ()
    """Closures that it did not know of."""


class KnowledgeView(View, kw_only=True):
    """What one agent knew at a moment; differences come first."""

    agent: str
    at_s: float
    items: tuple[KnownView, ...] = ()


class Involvement(msgspec.Struct, kw_only=True):
    """What a picture tells of an agent and its tasks: all that is kept of the picture."""

    agent: str
    at_s: float
    """The moment."""
    is_known: bool
    """Whether there was such an agent."""
    roles: dict[str, str]
    """Its tasks and its role in each; empty for a role that it has lost."""
    tasks: dict[str, TaskView]
    """Those of its tasks that the picture has."""
    heard_at_s: float | None = None
    is_overdue: bool = False
    """Whether it had been silent for too long."""
    closures: tuple[str, ...] = ()
    """Closures that it did not know of."""


def involvement(picture: PlantPicture, agent: str, at_s: float) -> Iterator[Involvement]:
    """The tasks of an agent and its role in each, by its own word first, then by the coordinators'.

    Yields the same `Involvement` again after every `PORTION` tasks, so that other work can run; it is complete
    at the end.
    """
    atv = picture.atvs.view(agent)
    view = atv or picture.machines.view(agent) or picture.stations.view(agent)
    of = Involvement(agent=agent, at_s=at_s, is_known=view is not None, roles={}, tasks={})
    if view is not None:
        of.heard_at_s = view.seen_at_s
        of.is_overdue = (at_s - view.seen_at_s) * picture.speed > view.silence.overdue_after_s
        of.closures = tuple(each.id for each in picture.closures.views() if agent in each.not_known_by)
    if atv is not None:
        if atv.task is not None:
            of.roles[atv.task.task] = "primary"
        of.roles |= {brief.task: "secondary" for brief in atv.watches}
        for name in of.roles:
            if (task := picture.tasks.view(name)) is not None:
                of.tasks[name] = task
    yield of
    if view is None:
        return
    for number, name in enumerate(reversed(tuple(picture.tasks.ids())), 1):
        if len(of.roles) >= TASKS_MOST:
            return
        if name not in of.roles and (task := picture.tasks.view(name)) is not None:
            role = _role(task, agent, at_s)
            if role is not None:
                of.roles[name], of.tasks[name] = role, task
        if number % PORTION == 0:
            yield of


def _role(task: TaskView, agent: str, at_s: float) -> str | None:
    """The role of an agent in a task, by its coordinator's word; None if it has nothing to do with it."""
    if task.closed_at_s is None and task.coordinator == agent:
        return "coordinator"
    if task.closed_at_s is None and agent in (task.primary, task.secondary):
        return "primary" if agent == task.primary else "secondary"
    had = any(agent in (carrier.carrier, carrier.replaced) for carrier in task.carriers)
    return "" if had and (task.closed_at_s is None or at_s - task.closed_at_s < LOST_KEPT_S) else None


def knowledge(of: Involvement, rows: Iterable[EventRow]) -> KnowledgeView:
    """What an agent knew.

    Args:
        of: the agent, the moment and its tasks.
        rows: all events of these tasks with facts in `TELLING`, in order of time.
    """
    by_task: dict[str, list[EventRow]] = {task: [] for task in of.roles}
    for row in rows:
        by_task.setdefault(row.task or "", []).append(row)
    items = [_of_task(of, task, role, by_task[task]) for task, role in of.roles.items() if by_task[task]]
    if of.heard_at_s is not None:
        items.append(KnownView(about="heard", differs=of.is_overdue, heard_at_s=of.heard_at_s))
    if of.closures:
        items.append(KnownView(about="closures", differs=True, closures=of.closures))
    items.sort(key=lambda item: not item.differs)
    return KnowledgeView(agent=of.agent, at_s=of.at_s, items=tuple(items))


def _of_task(of: Involvement, task: str, role: str, rows: Sequence[EventRow]) -> KnownView:
    agent, at_s = of.agent, of.at_s
    own = [row for row in rows if row.agent == agent]
    knew = next((row for row in reversed(own) if row.at_s <= at_s), None)
    upsetting = {kind.__name__ for kind in UPSETTING}
    happened = next(
        (row for row in reversed(rows) if row.at_s <= at_s and row.agent != agent and row.kind in upsetting),
        None,
    )
    learnt_s: float | None = None
    differs = False
    if happened is not None:
        after = (row.at_s for row in own if row.at_s >= happened.at_s)
        learnt_s = next(after, None)
        differs = learnt_s is None or learnt_s > at_s
    view = of.tasks.get(task)
    return KnownView(
        about="task",
        differs=differs,
        task=task,
        role=role,
        item="" if view is None else view.item,
        source="" if view is None else view.source,
        destination="" if view is None else view.destination,
        knew=None if knew is None else _told(knew),
        happened=None if happened is None else _told(happened),
        learnt_at_s=learnt_s,
    )


def _told(row: EventRow) -> RecordedFactView | None:
    try:
        fact = _READ.decode(row.fact)
    except msgspec.MsgspecError:
        return None  # It was written by another version of Dray.
    other = ""
    match fact:
        case CarrierChanged(carrier=carrier, replaced=replaced):
            other = carrier or replaced
        case TookOver(primary=primary) | PrimarySuspected(primary=primary):
            other = primary
        case WatchLost(secondary=secondary):
            other = secondary
        case _:
            pass
    return RecordedFactView(
        kind=row.kind,
        agent=row.agent,
        at_s=row.at_s,
        role=_word(fact, "role"),
        reason=_word(fact, "reason"),
        phase=_word(fact, "phase"),
        outcome=_word(fact, "outcome"),
        other=other,
    )


def _word(fact: object, name: str) -> str:
    value = getattr(fact, name, "")
    return str(getattr(value, "value", value))
