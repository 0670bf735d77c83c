"""The judgement over a factory whose processes were killed: which violations there were.

The checks are the simulator's invariants (`dray_sim.checks.invariants`), which replay the messages afterwards. Counts
of the final state of floor and database are added. Pure.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import inf

from dray.messages import Event, MachineHeartbeat, Message, OrderItem, OrderReleased, Role, Transport
from dray.messages.fact import (
    AwardAnswered,
    CarrierChanged,
    ContractEnded,
    ContractTaken,
    TaskClosed,
    TaskOpened,
)
from dray.store.orders.orders import Order
from dray.store.orders.progress import OrderStatus
from dray_sim.bench.losses.history import History
from dray_sim.bodies.floor import Pieces
from dray_sim.checks.broken import InvariantBroken
from dray_sim.checks.delivered import DeliveredExactly
from dray_sim.checks.invariants import HandedOverOnce, MaterialConserved, OnePrimaryEach, TasksEnd
from dray_sim.network.listeners import Listener

ENDED = "processes ended by themselves"
"""The only finding that a busy computer may cause instead of an agent: a process ends when its peer does not answer
in time."""


@dataclass(frozen=True, slots=True)
class Aftermath:
    """All that is known when everything is over.

    Attributes:
        history: of all agents.
        unwritten: facts that agents reported before the last kill and that the database lacks, in words.
        heartbeats: the last one of every machine.
        accepted: the ids of orders that were answered with 201, by the customer's reference.
        refused: why other orders were not.
        orders: all that the database has.
        first, last: all pieces on the floor, at the beginning and in the end.
        starts: how often each process was started.
        kills: how often each was killed.
    """

    history: History
    unwritten: Sequence[str]
    heartbeats: Sequence[MachineHeartbeat]
    accepted: Mapping[str, str]
    refused: Mapping[str, str]
    orders: Sequence[Order]
    first: Pieces
    last: Pieces
    starts: Mapping[str, int]
    kills: Mapping[str, int]


@dataclass(frozen=True, slots=True)
class Finding:
    """Something that must not be.

    Attributes:
        what: the violation in the plural, as "tasks lost".
        of: how many could have been.
        of_what: the unit of `of`.
        seen: every case of it, in words.
    """

    what: str
    of: int
    of_what: str
    seen: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class _Utterance:
    at_s: float
    sender: str
    message: Message


def judge(after: Aftermath) -> list[Finding]:
    """Find all violations."""
    events = after.history.events
    said = sorted(_said(events, after.heartbeats), key=lambda utterance: utterance.at_s)
    released = [_Utterance(0.0, "gateway", _release(order)) for order in after.orders]
    facts = Counter(type(event.fact) for event in events)
    pieces = sum(sum(order.quantities) for order in after.orders)
    arrived = after.last.arrived
    return [
        Finding("tasks lost", facts[TaskOpened], "announcements", _broken(TasksEnd(), said)),
        Finding("handovers doubled", facts[TaskClosed], "tasks ended", _broken(HandedOverOnce(), said)),
        Finding(
            "vehicles with two tasks", facts[ContractTaken], "contracts", _broken(OnePrimaryEach(), said)
        ),
        Finding("contracts lost for nothing", facts[ContractTaken], "contracts", tuple(_for_nothing(events))),
        Finding(
            "pieces too many or too few",
            pieces,
            "pieces ordered",
            (
                *_broken(DeliveredExactly(lambda goal: arrived.get(goal, 0)), [*released, *said]),
                *_not_as_ordered(after),
            ),
        ),
        Finding("accepted orders lost", len(after.accepted), "orders accepted", tuple(_lost_orders(after))),
        Finding("orders doubled", len(after.orders), "orders", tuple(_doubled_orders(after))),
        Finding("orders refused", len(after.accepted), "orders accepted", tuple(_refusals(after))),
        Finding("pieces lost or made of nothing", pieces, "pieces ordered", _unbalanced(after)),
        Finding(ENDED, len(after.starts), "processes", tuple(_fallen(after))),
        Finding("holes in histories", len(events), "facts", tuple(after.history.holes)),
        Finding("facts not in the database", len(events), "facts", tuple(after.unwritten)),
    ]


def _said(events: Iterable[Event], heartbeats: Iterable[MachineHeartbeat]) -> Iterable[_Utterance]:
    for event in events:
        yield _Utterance(event.at_s, event.agent, event)
    for heartbeat in heartbeats:
        yield _Utterance(heartbeat.at_s, heartbeat.machine, heartbeat)


def _release(order: Order) -> OrderReleased:
    items = tuple(OrderItem(item.product, item.quantity) for item in order.items)
    return OrderReleased(order=order.id, items=items, due_s=0.0)


def _broken(check: Listener, said: Iterable[_Utterance]) -> tuple[str, ...]:
    """Violations of one invariant; after the first, others may be its consequences."""
    found = []
    for utterance in said:
        try:
            check.on_message(utterance.at_s, utterance.sender, "", utterance.message)
        except InvariantBroken as broken:
            found.append(str(broken))
    return tuple(found)


def _for_nothing(events: Sequence[Event]) -> Iterable[str]:
    """Transports of which a carrier was released that its coordinator had contracted and not replaced since.

    A release is left out in these cases. The carrier was silent when it was asked, even if it was asked again later.
    Or it took over from a living vehicle. The same holds for a carrier that comes back after its task has ended.
    Such a task was withdrawn, because its goal was given to another machine or waited in vain. Or its load was
    counted before the kill, and its coordinator has restarted since.
    """
    accepted_s: dict[tuple[str, int, str], float] = {}
    let_go: set[tuple[str, str]] = set()
    counted_s: dict[tuple[str, str], float] = {}
    transports: set[str] = set()
    for event in events:
        match event.fact:
            case TaskOpened(task=task, work=Transport()):
                transports.add(task)
            case AwardAnswered(role=Role.PRIMARY, answer="accepted") as answer:
                accepted_s.setdefault((answer.task, answer.epoch, answer.bidder), event.at_s)
            case CarrierChanged(task=task, replaced=carrier):
                let_go.add((task, carrier))
            case TaskClosed(outcome="withdrawn", task=task, carrier=carrier):
                let_go.add((task, carrier))
            case TaskClosed(task=task, carrier=carrier):
                counted_s[task, carrier] = event.at_s
    for event in events:
        match event.fact:
            case ContractEnded(role=Role.PRIMARY, reason="released", task=task, epoch=epoch) if (
                task in transports
                and accepted_s.get((task, epoch, event.agent), inf) < event.at_s
                and (task, event.agent) not in let_go
                and counted_s.get((task, event.agent), inf) > event.at_s
            ):
                yield f"{event.agent} was released from {task} (epoch {epoch}), which it had"


def _not_as_ordered(after: Aftermath) -> Iterable[str]:
    """Differences between the orders and the floor's own count at the delivery warehouses."""
    ordered: Counter[str] = Counter()
    for order in after.orders:
        for item in order.items:
            ordered[item.product] += item.quantity
    for product in sorted(ordered.keys() | after.last.delivered.keys()):
        delivered = after.last.delivered.get(product, 0) - after.first.delivered.get(product, 0)
        if delivered != ordered[product]:
            yield f"{delivered} pieces of {product} arrived, {ordered[product]} were ordered"


def _lost_orders(after: Aftermath) -> Iterable[str]:
    status = {order.id: order.status for order in after.orders}
    for reference, order in after.accepted.items():
        if order not in status:
            yield f"{reference} was accepted as {order}, which nobody knows"
        elif status[order] is not OrderStatus.DELIVERED:
            yield f"{reference} was accepted as {order}, which is {status[order].value}"


def _doubled_orders(after: Aftermath) -> Iterable[str]:
    times = Counter(order.reference for order in after.orders)
    return (f"{reference} is there {count} times" for reference, count in times.items() if count > 1)


def _refusals(after: Aftermath) -> Iterable[str]:
    return (f"{reference}: {reason}" for reference, reason in after.refused.items())


def _unbalanced(after: Aftermath) -> tuple[str, ...]:
    counts = iter((after.first.balance, after.last.balance))
    try:
        MaterialConserved(lambda: next(counts)).check(0.0)
    except InvariantBroken as broken:
        return (broken.seen,)
    return ()


def _fallen(after: Aftermath) -> Iterable[str]:
    """An agent never ends by itself (invariant 8), so it is started once more than it was killed."""
    for name, starts in after.starts.items():
        kills = after.kills.get(name, 0)
        if starts != kills + 1:
            yield f"{name} was killed {kills} times and started {starts} times"
