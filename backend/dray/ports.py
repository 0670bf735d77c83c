"""Ports: what the worker of an agent needs from the world. The docstrings are guarantees.

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
    Cancellation: there is none. A callback that is not needed any more must recognise that itself;
    this keeps the hot path free of handles.
    """

    def now_s(self) -> float:
        """Seconds on the plant's clock; never goes back."""
        ...

    def call_at(self, when_s: float, callback: Callable[[], None]) -> None:
        """Call back at `when_s`; a time that is past means as soon as possible."""
        ...


class Session(Protocol):
    """One agent's place on the bus.

    Delivery: at most once, and nobody is told when it fails: the protocol repeats what matters.
    Order: messages from one sender to one receiver over one kind of call arrive in the order sent,
    as long as the network has no fault; the protocol must not rely on it.
    Blocking: no method blocks. What cannot be sent is dropped and counted, never queued without bound.
    An agent hears its own publications when it subscribes to them.

    Attributes:
        context: the trace to which it belongs what is being said or heard (W3C traceparent); empty for none.
            Set before something is said, to be read while something is received. Some ways, such as the
            radio, have no room for it; it means nothing to the protocol.
    """

    context: str

    def publish(self, key: str, message: Message) -> None:
        """Say it to all whose subscriptions match `key`. `key` holds no wildcard."""
        ...

    def send(self, to: str, message: Message) -> None:
        """Say it to one agent alone; nobody else hears it. An unknown agent is silence."""
        ...

    def subscribe(self, key: str) -> None:
        """Hear what is published on `key` from now on (`*`: one chunk, `**`: any). Twice is once."""
        ...

    def unsubscribe(self, key: str) -> None:
        """Hear it no longer, except what is already under way."""
        ...

    def leave(self) -> None:
        """Leave the bus; nothing is received after the return. Twice is harmless."""
        ...


class Bus(Protocol):
    """Where agents meet. There may be any number of agents; none of them is special.

    Who may say what: before anybody hears a message, `dray.messages.speakers.objection` is asked. What is refused
    reaches nobody, and is counted by reason.
    """

    def join(self, agent: str, receive: Receive, life: int = 0) -> Session:
        """Take part as `agent`.

        Of several lives of one agent the latest stays, wherever they are and whichever joined first, and the others
        leave. Without clocks: a process that hung while its computer's clock was put back must not win over its
        restart.

        Args:
            agent: its id.
            receive: hears what is said to it.
            life: its incarnation (`Journal`). 0 for who keeps no journal: it gives way to whoever joins after it in the
                same process, or with a life elsewhere.
        """
        ...


class Journal(Protocol):
    """One agent's durable notes: they outlive its process, and nobody else reads them.

    Atomic: one `write` is there after a restart wholly or not at all. Order: it is durable when the call
    returns. Blocking: a call may take as long as a small write to a local disk. Bounded: old events are
    dropped, oldest first, over all lives.
    """

    @property
    def incarnation(self) -> int:
        """How often this agent has been started: 1 in its first life."""
        ...

    @property
    def memory(self) -> Memory:
        """The notes as they were written last, in the order in which each was first written; read anew each time."""
        ...

    @property
    def lost(self) -> str:
        """Why nothing is remembered though the agent has lived before; empty when that is not so.

        It is said until a life has written its first events: that life's number is greater than all before, too.
        """
        ...

    def write(self, events: Sequence[Event], changes: Changes) -> None:
        """Keep these events until they are old, and replace or forget these notes; all others stay.

        It costs as much as what is given, whatever else is kept.
        The numbers of events go on from those of the same life that were written before.
        """
        ...

    def kept(self, incarnation: int) -> tuple[int, int]:
        """The first and the last number of the kept events of one life; (1, 0) when there are none."""
        ...

    def events(self, incarnation: int, first: int, last: int) -> list[Event]:
        """The kept events of one life with these numbers, both ends included, in order."""
        ...


class Body(Protocol):
    """An agent's hands and senses: a vehicle or a workcell.

    Order: instructions take effect in the order given, reports come in the order in which things
    happened. Blocking: no method blocks. An instruction that cannot be carried out is answered with
    a failure report, never with an exception.
    """

    def instruct(self, instruction: Instruction) -> None:
        """Do this, beginning now."""
        ...

    def sense(self) -> BodyState:
        """How things are at this moment. Changes nothing."""
        ...

    def attach(self, report: Callable[[Report], None]) -> None:
        """Report to this callable from now on, and to no other."""
        ...
