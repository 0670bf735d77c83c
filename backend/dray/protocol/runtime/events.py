"""The events that can happen to an agent, and the effects it can ask for.

An agent is a pure state machine. It is called as ``handle(event, now_s)`` with a time that never goes back, and
returns effects. Their order is a contract: the worker carries them out in the given order. `wake_at_s` is the time
of the next wake-up; it is read after every call. An early or needless wake-up is harmless.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import Protocol

import msgspec

from dray.body import BodyState, Instruction, Report
from dray.memory import WHOLE, Memory, Note
from dray.messages import AnyFact, Message

NEVER_S = float("inf")
"""The wake-up time of an agent that waits only for messages."""

NOT_FOR_US = "a message of a type that this agent does not handle"
"""Why a message of a known type is ignored: newer software may send messages that older software does not handle."""


class Value(msgspec.Struct, frozen=True, gc=False):
    """An immutable event or effect."""


# --- events --------------------------------------------------------------------------------------


class Started(Value, frozen=True):
    """The first event of an agent's life."""

    body: BodyState | None
    memory: Memory = MappingProxyType({})
    """What earlier lives have committed; empty in the first one."""
    lost: str = ""
    """Why the memory is empty although the agent has lived before; empty if that is not so."""


class Received(Value, frozen=True):
    """A message has arrived."""

    sender: str
    message: Message
    body: BodyState | None = None
    """What the agent's body senses now, given with a person's command and with messages about right of way: a vehicle's
    options then depend on its position. None with other messages."""


class Woke(Value, frozen=True):
    """`wake_at_s` has come, or may have."""

    body: BodyState | None
    """What the agent's body senses at this moment; None for an agent without one."""
    late_s: float = 0.0
    """How much later than requested this came (s): the agent's own process was held up, and heard nobody."""


class Reported(Value, frozen=True):
    """The body has a report."""

    report: Report


class Leaving(Value, frozen=True):
    """The agent is asked to shut down gracefully; see `dray.protocol.runtime.shutdown`. Twice is harmless."""


Event = Started | Received | Woke | Reported | Leaving

# --- effects -------------------------------------------------------------------------------------


class Publish(Value, frozen=True):
    """Publish a message to all subscribers of `key`."""

    key: str
    message: Message


class Send(Value, frozen=True):
    """Send a message to one agent."""

    to: str
    message: Message


class Subscribe(Value, frozen=True):
    """Subscribe to `key`."""

    key: str


class Unsubscribe(Value, frozen=True):
    """Unsubscribe from `key`."""

    key: str


class Instruct(Value, frozen=True):
    """Let the body act."""

    instruction: Instruction


class Record(Value, frozen=True):
    """Write a fact into the agent's numbered history, and publish it."""

    fact: AnyFact


class Commit(Value, frozen=True):
    """Store a part of what the agent is bound by, and replace that part's earlier version.

    It is stored atomically with the other parts and the facts of the same step, before any effect of the step is
    carried out: a restart never forgets what was said.
    """

    note: Note | None
    """None deletes the part of that name."""
    name: str = WHOLE


class Ignore(Value, frozen=True):
    """Count a message that changed nothing: late, doubled, stale, or not for this agent.

    That is normal on a real network; it is counted so that people see when it is not.
    """

    reason: str


class Leave(Value, frozen=True):
    """End this life: the agent was asked to leave, and has no reason to stay. The last effect of its step."""

    again: bool = False
    """Whether a person has asked for its next life: the supervisor starts it again."""
    update: bool = False
    """Whether the next life uses the newest installed software."""


Effect = Publish | Send | Subscribe | Unsubscribe | Instruct | Record | Commit | Ignore | Leave


class Agent(Protocol):
    """What the worker runs."""

    @property
    def id(self) -> str:
        """The agent's name on the bus."""
        ...

    @property
    def incarnation(self) -> int:
        """How often this agent has been started, 1 for the first time."""
        ...

    @property
    def wake_at_s(self) -> float:
        """When it wants to be woken; `NEVER_S` if not at all."""
        ...

    def handle(self, event: Event, now_s: float) -> list[Effect]:
        """Take one step.

        Args:
            event: the event.
            now_s: the time on the plant's clock; never less than in the call before.

        Returns:
            The effects to carry out, in this order.

        Raises:
            ProtocolViolation: for a state that the protocol excludes; our own bug.
        """
        ...
