"""Ports: what an agent's worker needs from the world. The docstrings are guarantees.

Every port has one conformance suite in `tests/contracts/` that all of its implementations run:
`dray_sim` implements them for the simulated world, `dray.adapters` for the real one.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

from dray.body import BodyState, Instruction, Report
from dray.memory import Changes, Memory
from dray.messages import Event, Message

Receive = Callable[[str, Message], None]
"""Called with (sender, message). Must not block, and must not raise."""


class Clock(Protocol):
    """The plant's clock. All agents of one plant share it within 100 ms.

    Order: callbacks run in the order of their times; equal times in the order of the calls.
    Blocking: no method blocks. Callbacks run on the loop of the agent, never inside `call_at`.
    Cancellation: there is none. An outdated callback must recognise itself as such; this keeps the hot path free of
    handles.
    """

    def now_s(self) -> float:
        """Seconds on the plant's clock; never goes back."""
        ...

    def call_at(self, when_s: float, callback: Callable[[], None]) -> None:
        """Call back at `when_s`; a past time means as soon as possible."""
        ...


class Session(Protocol):
    """One agent's place on the bus.

    Delivery: at most once, and failures are not reported: the protocol repeats what matters.
    Order: messages from one sender to one receiver over one kind of call arrive in the order sent,
    as long as the network has no fault; the protocol must not rely on it.
    Blocking: no method blocks. Messages that cannot be sent are dropped and counted, never queued without bound.
    An agent hears its own publications when it subscribes to them.

    Attributes:
        context: the trace of the message being sent or received (W3C traceparent); empty for none. Set it before
            sending, and read it while receiving. Some transports, such as the radio, have no room for it. The
            protocol does not use it.
    """

    context: str

    def publish(self, key: str, message: Message) -> None:
        """Say it to all whose subscriptions match `key`. `key` holds no wildcard."""
        ...

    def send(self, to: str, message: Message) -> None:
        """Send it to one agent alone; nobody else hears it. A message to an unknown agent is lost silently."""
        ...

    def subscribe(self, key: str) -> None:
        """Hear what is published on `key` from now on (`*`: one chunk, `**`: any). Subscribing twice equals once."""
        ...

    def unsubscribe(self, key: str) -> None:
        """Stop hearing it, except for messages already under way."""
        ...

    def leave(self) -> None:
        """Leave the bus; nothing is received after the return. Twice is harmless."""
        ...


class Bus(Protocol):
    """The agents' message bus. There may be any number of agents; none of them is special.

    Access: `dray.messages.speakers.objection` checks every message before it is delivered. A refused message reaches
    nobody and is counted by reason.
    """

    def join(self, agent: str, receive: Receive, life: int = 0) -> Session:
        """Take part as `agent`.

        If several lives of one agent join, the latest life stays, wherever it is and whichever joined first; the others leave. The
        rule uses no clocks: a hung process whose computer's clock was set back must not win over its restart.

        Args:
            agent: its id.
            receive: hears what is said to it.
            life: its incarnation (`Journal`). 0 for an agent without a journal: it gives way to any later join in the
                same process, and to any life elsewhere.
        """
        ...


class Journal(Protocol):
    """One agent's durable notes: they outlive its process, and nobody else reads them.

    Atomic: after a restart one `write` is there wholly or not at all. Order: it is durable when the call
    returns. Blocking: a call may take as long as a small write to a local disk. Bounded: the oldest events
    are dropped first, over all lives.
    """

    @property
    def incarnation(self) -> int:
        """How often this agent has been started: 1 in its first life."""
        ...

    @property
    def memory(self) -> Memory:
        """The notes as last written, in the order in which each was first written; read anew each time."""
        ...

    @property
    def lost(self) -> str:
        """Why nothing is remembered though the agent has lived before; empty otherwise.

        It is given until a life has written its first events: that life's number is also greater than all before.
        """
        ...

    def write(self, events: Sequence[Event], changes: Changes) -> None:
        """Store these events until they are old, and replace or delete these notes; other notes stay.

        The cost depends only on the given events and notes. Event numbers continue those of the same life.
        """
        ...

    def kept(self, incarnation: int) -> tuple[int, int]:
        """The first and the last number of the stored events of one life; (1, 0) when there are none."""
        ...

    def earlier(self, before: int, most: int) -> list[tuple[int, int, int]]:
        """The newest lives with stored events, oldest first: life, first and last number of each.

        Args:
            before: only lives before this one.
            most: maximum number of lives.
        """
        ...

    def events(self, incarnation: int, first: int, last: int) -> list[Event]:
        """The stored events of one life with these numbers, both ends included, in order."""
        ...


class Body(Protocol):
    """An agent's hands and senses: a vehicle or a workcell.

    Order: instructions take effect in the order given, reports come in the order in which things
    happened. Blocking: no method blocks. An instruction that cannot be carried out is answered with
    a failure report, never with an exception.
    """

    def instruct(self, instruction: Instruction) -> None:
        """Carry this out, beginning now."""
        ...

    def sense(self) -> BodyState:
        """The body's present state. Changes nothing."""
        ...

    def attach(self, report: Callable[[Report], None]) -> None:
        """Report to this callable from now on, and to no other.

        From now on no instruction of an earlier life takes effect, and `sense` contains what those before have done.
        """
        ...


def nobody_hears(_report: Report) -> None:
    """Ignore a body's reports before its agent listens, and after that has gone: the body's state contains them."""
