"""Knowledge: what an agent knew at a moment, beside what had really happened by then. Pure.

Every agent numbers its own events and reports those later that nobody heard at the time. Its own events about
its transports up to a moment are what it knew. Other agents' events up to that moment are what had happened.
Its next event on the same transport shows when it learnt of that.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Literal

import msgspec

from dray.gateway.live.replay.film import Picture
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


def tasks_of(picture: Picture, agent: str) -> dict[str, str]:
    """The tasks of an agent and its role in each, by its own word first, then by the coordinators'."""
    roles: dict[str, str] = {}
    atv = picture.atvs.view(agent)
    if atv is not None:
        if atv.task is not None:
            roles[atv.task.task] = "primary"
        roles |= {brief.task: "secondary" for brief in atv.watches}
    views: Sequence[TaskView] = picture.tasks.views()
    for task in reversed(views):
        if len(roles) >= TASKS_MOST:
            break
        if task.id in roles:
            continue
        if task.closed_at_s is None and task.coordinator == agent:
            roles[task.id] = "coordinator"
        elif task.closed_at_s is None and agent in (task.primary, task.secondary):
            roles[task.id] = "primary" if agent == task.primary else "secondary"
        elif any(agent in (carrier.carrier, carrier.replaced) for carrier in task.carriers) and (
            task.closed_at_s is None or picture.at_s - task.closed_at_s < 60.0
        ):
            roles[task.id] = ""
    return roles


def knowledge(
    picture: Picture, agent: str, at_s: float, roles: Mapping[str, str], rows: Iterable[EventRow]
) -> KnowledgeView:
    """What an agent knew.

    Args:
        picture: the plant at the moment.
        agent: the agent whose knowledge is asked for.
        at_s: the moment.
        roles: the result of `tasks_of`.
        rows: all events of these tasks with facts in `TELLING`, in order of time.
    """
    by_task: dict[str, list[EventRow]] = {task: [] for task in roles}
    for row in rows:
        by_task.setdefault(row.task or "", []).append(row)
    items = [
        _of_task(picture, agent, at_s, task, role, by_task[task])
        for task, role in roles.items()
        if by_task[task]
    ]
    view = picture.atvs.view(agent) or picture.machines.view(agent) or picture.stations.view(agent)
    if view is not None:
        silent_s = (at_s - view.seen_at_s) * picture.speed
        items.append(
            KnownView(
                about="heard", differs=silent_s > view.silence.overdue_after_s, heard_at_s=view.seen_at_s
            )
        )
    unknown = tuple(each.id for each in picture.closures.views() if agent in each.not_known_by)
    if unknown:
        items.append(KnownView(about="closures", differs=True, closures=unknown))
    items.sort(key=lambda item: not item.differs)
    return KnowledgeView(agent=agent, at_s=at_s, items=tuple(items))


def _of_task(
    picture: Picture, agent: str, at_s: float, task: str, role: str, rows: Sequence[EventRow]
) -> KnownView:
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
    view = picture.tasks.view(task)
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
