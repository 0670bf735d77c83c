"""The check that every bus makes before a message is delivered: may its sender send it (`objection`).

Names are checked on every bus: only its owner speaks on a key that belongs to one agent, and a message names its true sender.
Kinds are checked where they are known, by certificates or in a simulated plant: a vehicle cannot send a machine's messages or a
strategist's facts, and only a gateway sends orders. Each message and each fact defines the kinds that may send it.
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
    """The name of the agent by which a gateway sends stops, beside its own."""
    return gateway + STOP_SUFFIX


def names_of(agent: str, kind: Kind) -> dict[str, Kind]:
    """The names, and their kinds, for which an agent's process speaks by its certificate."""
    names = (agent, stop_sender_of(agent)) if kind is Kind.GATEWAY else (agent,)
    return dict.fromkeys(names, kind)


def kind_in(agent: str, certified: Mapping[str, Kind]) -> Kind | None:
    """An agent's kind by a certificate with these names; None when the certificate does not cover the agent.

    No certificate names people, who come and go: one for a gateway also covers the operators at its tablets.
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
    """Why a message must not be delivered, as a reason to count; empty when it may be.

    Args:
        sender: its original sender, also when others have forwarded it.
        kind: the sender's kind; None when unknown, as on a bus without certificates.
        key: the key on which it was sent; keys for one addressee have no owner.
        message: the message.
        shut_out: agents whose messages are all ignored, but for gateways: the list may be a thief's, and they correct it.
    """
    if sender in shut_out and kind is not Kind.GATEWAY:
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
