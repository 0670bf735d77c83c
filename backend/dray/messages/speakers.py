"""Who may say what: the one place that every bus asks before anybody hears a message (`objection`).

Names hold on every bus: on a key that belongs to one agent nobody else speaks, and whatever a message says
of its speaker is true. Kinds hold where they are known, by certificates or in a simulated plant: a vehicle has
neither a machine's words nor a strategist's facts, and nobody but a gateway gives orders. Every message says by which
kinds it may be said, where it is defined, and every fact by which it may be told.
"""

from __future__ import annotations

from collections.abc import Container, Mapping

from dray.messages.base import Message
from dray.messages.history import Event
from dray.messages.keys import owner_of
from dray.messages.kinds import Kind
from dray.messages.people.operator import OPERATOR_PREFIX

STOP_SUFFIX = "-stop"


def stop_sender_of(gateway: str) -> str:
    """The name of the agent by which a gateway says stops, beside its own."""
    return gateway + STOP_SUFFIX


def names_of(agent: str, kind: Kind) -> dict[str, Kind]:
    """Whom the process of an agent speaks for, as its certificate says."""
    names = (agent, stop_sender_of(agent)) if kind is Kind.GATEWAY else (agent,)
    return dict.fromkeys(names, kind)


def kind_in(agent: str, certified: Mapping[str, Kind]) -> Kind | None:
    """What an agent is by a certificate that names these; None when the certificate is not good for it.

    People come and go, so no certificate names them: whoever may speak for a gateway may speak for the operators at its tablets.
    """
    if agent.startswith(OPERATOR_PREFIX) and Kind.GATEWAY in certified.values():
        return Kind.OPERATOR
    return certified.get(agent)


SHUT_OUT = "an agent that is shut out"
FOREIGN_KEY = "another agent's key"
FOREIGN_NAME = "another agent's name"
FOREIGN_WORD = "a word that its kind does not have"
FOREIGN_FACT = "a fact that its kind does not tell"


def objection(
    sender: str, kind: Kind | None, key: str, message: Message, shut_out: Container[str] = ()
) -> str:
    """Why nobody should hear this from `sender`, as a reason to count; empty when all is well.

    Args:
        sender: who has really said it, whoever has passed it on.
        kind: what the sender is; None where nobody knows, as on a bus without certificates.
        key: on which it was said; what is said to one agent alone belongs to no key of anybody's.
        message: what was said.
        shut_out: agents that nobody hears any more, whatever they say.
    """
    if sender in shut_out:
        return SHUT_OUT
    if owner_of(key) not in (None, sender):
        return FOREIGN_KEY
    if message.signed and getattr(message, message.signed) != sender:
        return FOREIGN_NAME
    if kind is None:
        return ""
    if kind not in message.said_by:
        return FOREIGN_WORD
    if isinstance(message, Event) and kind not in message.fact.told_by:
        return FOREIGN_FACT
    return ""
