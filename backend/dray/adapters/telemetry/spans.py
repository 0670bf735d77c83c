"""Spans: an agent's work on each of its tasks, for OpenTelemetry.

They are made of the agent's own messages: its facts begin and end them, and every message about a task carries the
context of the present work. So the protocol knows nothing of traces.

    coordinator  task    auction  auction ...          a round each, with its bids as events
    contractor        bid         carry  approaching  loading ...      or watch, or produce

The parent of a contractor's span is the coordinator's work at its last received message. A transport of a goal's goods belongs
to the goal: its trace begins with the strategist's announcement. Times are those of the facts.
"""

from __future__ import annotations

import re
from collections import OrderedDict
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from opentelemetry.trace import (
    NonRecordingSpan,
    Span,
    SpanContext,
    Status,
    StatusCode,
    TraceFlags,
    Tracer,
    set_span_in_context,
)

from dray.messages import Event, Message, Production, Role, Transport
from dray.messages.contract import Award, TaskAnnounced
from dray.messages.fact import (
    AnyFact,
    AwardAnswered,
    BidRefused,
    BidSent,
    CarrierChanged,
    ContractEnded,
    ContractTaken,
    PhaseEntered,
    RoundFailed,
    TaskClosed,
    TaskOpened,
    TookOver,
)

if TYPE_CHECKING:
    from opentelemetry.util.types import AttributeValue

TASKS = 2_000
"""Maximum tasks with a remembered context: those of an hour's announcements in a plant of 200 vehicles. The oldest go
first, and their open spans end."""

_TRACEPARENT = re.compile(r"00-([0-9a-f]{32})-([0-9a-f]{16})-([0-9a-f]{2})")

ACCEPTED = "accepted"


class _Task:
    """An agent's spans for one task."""

    __slots__ = ("auctions", "bid", "contract", "parent", "phase", "produces", "root")

    def __init__(self) -> None:
        self.parent: Span | None = None
        """The context of the last message about it."""
        self.root: Span | None = None
        """The coordinator's span, from the first announcement to the end."""
        self.auctions: dict[Role, Span] = {}
        self.bid: Span | None = None
        self.contract: Span | None = None
        self.phase: Span | None = None
        self.produces = False

    @property
    def current(self) -> Span | None:
        """The agent's most specific open span of the task."""
        auction = next(reversed(self.auctions.values()), None)
        return auction or self.contract or self.root or self.bid or self.parent


class Spans:
    """One agent's spans.

    Args:
        agent: its id.
        tracer: creates the spans.
        to_wall_s: plant clock to wall clock.
    """

    def __init__(self, agent: str, tracer: Tracer, to_wall_s: Callable[[float], float]) -> None:
        self._agent, self._tracer, self._to_wall_s = agent, tracer, to_wall_s
        self._tasks: OrderedDict[str, _Task] = OrderedDict()
        self._last_ns = 0
        """The time of the last fact."""

    def on_message(self, message: Message, context: str) -> None:
        """Take a message and its context; empty for none."""
        name = _task_of(message)
        if not name or not (parent := _read(context)):
            return
        task = self._task(name)
        task.parent = parent
        if isinstance(message, Award | TaskAnnounced):
            task.produces = isinstance(message.work, Production)

    def context_of(self, message: Message) -> str:
        """The context for a message about to be sent (W3C traceparent); empty for none."""
        task = self._tasks.get(_task_of(message))
        return "" if task is None or task.current is None else _write(task.current.get_span_context())

    def tell(self, event: Event) -> None:
        """Take a fact that the agent has just published."""
        self._last_ns = at_ns = int(self._to_wall_s(event.at_s) * 1e9)
        match event.fact:
            case TaskOpened() as fact:
                self._open(fact, at_ns)
            case AwardAnswered() | RoundFailed() as fact:
                self._answer(fact, at_ns)
            case TaskClosed() as fact:
                self._close(fact, at_ns)
            case BidSent() | BidRefused() as fact:
                self._bid(fact, at_ns)
            case TookOver() | ContractTaken() as fact:
                self._take(fact, at_ns)
            case PhaseEntered() as fact:
                self._enter(fact, at_ns)
            case ContractEnded() as fact:
                self._leave(fact, at_ns)
            case fact:
                self._remark(fact, at_ns)

    def close(self) -> None:
        """The agent has gone: end all open spans, at the time of its last fact."""
        for task in self._tasks.values():
            _end(task, self._last_ns)
        self._tasks.clear()

    # --- of a coordinator ------------------------------------------------------------------------

    def _open(self, fact: TaskOpened, at_ns: int) -> None:
        task = self._task(fact.task)
        if task.root is None:
            goal = self._tasks.get(fact.work.goal) if isinstance(fact.work, Transport) else None
            parent = task.parent if goal is None else goal.current
            task.root = self._begin("task", parent, fact, at_ns, _work(fact))
        self._end_auction(task, fact.role, at_ns)
        more: dict[str, AttributeValue] = {"dray.role": fact.role.value, "dray.round": fact.round}
        task.auctions[fact.role] = self._begin("auction", task.root, fact, at_ns, more)

    def _answer(self, fact: AwardAnswered | RoundFailed, at_ns: int) -> None:
        self._remark(fact, at_ns)
        task = self._task(fact.task)
        if isinstance(fact, RoundFailed):
            self._end_auction(task, fact.role, at_ns, Status(StatusCode.ERROR, "nobody was contracted"))
        elif fact.answer == ACCEPTED:
            self._end_auction(task, fact.role, at_ns)

    def _close(self, fact: TaskClosed, at_ns: int) -> None:
        task = self._task(fact.task)
        if task.root is not None:
            task.root.set_attributes({"dray.outcome": fact.outcome, "dray.carrier": fact.carrier})
        for role in list(task.auctions):
            self._end_auction(task, role, at_ns)
        root, task.root = task.root, None
        if root is not None:
            root.end(at_ns)
            # Later messages about it still belong to it.
            task.parent = root

    def _end_auction(self, task: _Task, role: Role, at_ns: int, status: Status | None = None) -> None:
        auction = task.auctions.pop(role, None)
        if auction is not None:
            if status is not None:
                auction.set_status(status)
            auction.end(at_ns)

    # --- of a contractor -------------------------------------------------------------------------

    def _bid(self, fact: BidSent | BidRefused, at_ns: int) -> None:
        task = self._task(fact.task)
        refused = isinstance(fact, BidRefused)
        more: dict[str, AttributeValue] = {"dray.role": fact.role.value}
        if isinstance(fact, BidRefused):
            more["dray.reason"] = fact.reason.value
        else:
            more["dray.total_s"] = fact.total_s
        task.bid = self._begin("refusal" if refused else "bid", task.parent, fact, at_ns, more)
        task.bid.end(at_ns)

    def _take(self, fact: TookOver | ContractTaken, at_ns: int) -> None:
        """A contract, by an award or by a takeover; a takeover's fact precedes that of its contract."""
        task = self._task(fact.task)
        if task.contract is not None and task.contract.is_recording():
            if isinstance(fact, ContractTaken):
                return
            task.contract.end(at_ns)
        role = fact.role if isinstance(fact, ContractTaken) else Role.PRIMARY
        name = "watch" if role is Role.SECONDARY else "produce" if task.produces else "carry"
        more: dict[str, AttributeValue] = {"dray.role": role.value}
        parent = task.parent
        if isinstance(fact, TookOver):
            parent = task.contract or parent
            more |= {
                "dray.replaces": fact.primary,
                "dray.silent_s": fact.silent_s,
                "dray.reason": fact.reason,
            }
        task.contract = self._begin(name, parent, fact, at_ns, more)

    def _enter(self, fact: PhaseEntered, at_ns: int) -> None:
        task = self._task(fact.task)
        _end_span(task.phase, at_ns)
        task.phase = self._begin(fact.phase.value, task.contract, fact, at_ns, {"dray.station": fact.station})

    def _leave(self, fact: ContractEnded, at_ns: int) -> None:
        task = self._task(fact.task)
        _end_span(task.phase, at_ns)
        task.phase = None
        if task.contract is not None:
            task.contract.set_attribute("dray.outcome", fact.reason)
            task.contract.end(at_ns)

    # --- of both ---------------------------------------------------------------------------------

    def _remark(self, fact: AnyFact, at_ns: int) -> None:
        """Add any other fact about a task as an event: of its auction for a role, or of the whole."""
        task = self._tasks.get(_task_of(fact))
        if task is None:
            return
        auction = task.auctions.get(fact.role) if hasattr(fact, "role") else None
        span = auction or task.root or task.contract
        if span is not None:
            span.add_event(type(fact).__name__, _plain(fact), at_ns)
        if isinstance(fact, CarrierChanged) and task.root is not None:
            task.root.set_attribute("dray.epoch", fact.epoch)

    def _begin(
        self, name: str, parent: Span | None, fact: object, at_ns: int, more: Mapping[str, AttributeValue]
    ) -> Span:
        attributes: dict[str, AttributeValue] = {
            "dray.agent": self._agent,
            "dray.task": _task_of(fact),
            "dray.epoch": getattr(fact, "epoch", 0),
            **more,
        }
        context = None if parent is None else set_span_in_context(parent)
        return self._tracer.start_span(name, context, attributes=attributes, start_time=at_ns)

    def _task(self, name: str) -> _Task:
        task = self._tasks.get(name)
        if task is None:
            if len(self._tasks) >= TASKS:
                _end(self._tasks.popitem(last=False)[1], self._last_ns)
            task = self._tasks[name] = _Task()
        return task


def _task_of(said: object) -> str:
    """The task of a message; empty for none. A heartbeat's `task` is more than its name."""
    task = getattr(said, "task", "")
    return task if isinstance(task, str) else ""


def _work(fact: TaskOpened) -> dict[str, AttributeValue]:
    match fact.work:
        case Transport(item=item, quantity=quantity, destination=destination, goal=goal):
            return {
                "dray.work": "transport",
                "dray.item": item,
                "dray.quantity": quantity,
                "dray.destination": destination,
                "dray.goal": goal,
            }
        case Production(product=product, quantity=quantity, order=order):
            return {
                "dray.work": "production",
                "dray.item": product,
                "dray.quantity": quantity,
                "dray.order": order,
            }


def _plain(fact: AnyFact) -> dict[str, AttributeValue]:
    """The text and number fields of a fact."""
    fields = {name: getattr(fact, name) for name in fact.__struct_fields__}
    return {f"dray.{name}": value for name, value in fields.items() if isinstance(value, str | int | float)}


def _end(task: _Task, at_ns: int) -> None:
    for span in (task.phase, task.contract, *task.auctions.values(), task.root):
        _end_span(span, at_ns)


def _end_span(span: Span | None, at_ns: int) -> None:
    if span is not None and span.is_recording():
        span.end(at_ns)


def _read(context: str) -> Span | None:
    """A span of another process; None when the text is no valid traceparent."""
    found = _TRACEPARENT.fullmatch(context)
    if found is None:
        return None
    trace, span, flags = (int(part, 16) for part in found.groups())
    there = SpanContext(trace, span, is_remote=True, trace_flags=TraceFlags(flags))
    return NonRecordingSpan(there) if there.is_valid else None


def _write(context: SpanContext) -> str:
    return f"00-{context.trace_id:032x}-{context.span_id:016x}-{context.trace_flags:02x}"
