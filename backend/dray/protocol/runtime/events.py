"""What can happen to an agent, and what an agent can want done.

An agent is a pure state machine. It is called as ``handle(event, now_s)`` with a time that never
goes back, and answers with effects. Their order is a contract: the worker carries them out one
after another, as given. `wake_at_s` tells when the agent wants to be woken; it is read after every
call, and being woken too early or for nothing is harmless.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import Protocol

import msgspec

from dray.body import BodyState, Instruction, Report
from dray.memory import WHOLE, Memory, Note
from dray.messages import AnyFact, Message

NEVER_S = float("inf")
"""The wake-up time of an agent that waits for nothing but messages."""

NOT_FOR_US = "a message that this kind of agent has no use for"
"""Why a message of a known type is ignored: a newer software may say things that older ones do not know."""


class Value(msgspec.Struct, frozen=True, gc=False):
    """An immutable event or effect."""


# --- events --------------------------------------------------------------------------------------


class Started(Value, frozen=True):
    """The first event of an agent's life."""

    body: BodyState | None
    memory: Memory = MappingProxyType({})
    """What its last lives have committed; empty in the first one."""
    lost: str = ""
    """Why it is empty though it has lived before; empty when that is not so."""


class Received(Value, frozen=True):
    """A message has arrived."""

    sender: str
    message: Message
    body: BodyState | None = None
    """What the agent's body senses at this moment, with a person's command and with words about right of way: what
    a vehicle may do then depends on where it is now. None with everything else."""


class Woke(Value, frozen=True):
    """`wake_at_s` has come, or may have."""

    body: BodyState | None
    """What the agent's body senses at this moment; None for an agent without one."""
    late_s: float = 0.0
    """How much later than it was asked for this came: so long the agent's own process was held up, and heard nobody."""


class Reported(Value, frozen=True):
    """The body has something to say."""

    report: Report


class Leaving(Value, frozen=True):
    """The agent is asked to shut down gracefully; see `dray.protocol.runtime.shutdown`. Twice is harmless."""


Event = Started | Received | Woke | Reported | Leaving

# --- effects -------------------------------------------------------------------------------------


class Publish(Value, frozen=True):
    """Say it to whoever listens on `key`."""

    key: str
    message: Message


class Send(Value, frozen=True):
    """Say it to one agent."""

    to: str
    message: Message


class Subscribe(Value, frozen=True):
    """Listen on `key`."""

    key: str


class Unsubscribe(Value, frozen=True):
    """Listen on `key` no longer."""

    key: str


class Instruct(Value, frozen=True):
    """Let the body act."""

    instruction: Instruction


class Record(Value, frozen=True):
    """Write a fact into the agent's numbered history, and publish it."""

    fact: AnyFact


class Commit(Value, frozen=True):
    """Write down a part of what the agent is bound by, replacing what was written of it before.

    It is written together with the other parts and the facts of the same step, wholly or not at all, before any
    effect of the step is carried out: what was said is never forgotten by a restart.
    """

    note: Note | None
    """None when there is nothing any more by that name."""
    name: str = WHOLE


class Ignore(Value, frozen=True):
    """Count a message that changed nothing: late, doubled, stale, or not for this agent.

    That is normal on a real network; it is counted so that somebody can see when it is not.
    """

    reason: str


class Leave(Value, frozen=True):
    """End this life: the agent was asked to leave, and nothing holds it any more. The last effect of its step."""

    again: bool = False
    """A person has asked for its next life: whoever runs it starts it again."""
    update: bool = False
    """With the newest software that lies ready."""


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
        """When it wants to be woken; `NEVER_S` for not at all."""
        ...

    def handle(self, event: Event, now_s: float) -> list[Effect]:
        """Take one step.

        Args:
            event: what has happened.
            now_s: the time on the plant's clock; never less than in the call before.

        Returns:
            What is to be done, in this order.

        Raises:
            ProtocolViolation: a state that the protocol excludes; our own bug.
        """
        ...
