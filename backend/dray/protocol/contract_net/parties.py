"""Whose word counts on a contract: what a coordinator alone may say of it is taken from that coordinator alone.

A contractor asks here before anything else is done; what is said of a dock is taken from whose dock it
is, a machine or the station of a storage (`atv`). Coordinators hear the words of contractors, and of those
who believe to be one, themselves: a stranger's is answered there, for it may be a carrier that was replaced.
"""

from __future__ import annotations

from collections.abc import Callable

from dray.messages import (
    Award,
    Confirmed,
    GoalClosed,
    GoalRevised,
    HandoverAccepted,
    Message,
    Release,
    Role,
    Superseded,
    Withdrawn,
)

NO_PARTY = "the word of somebody who is no party to the contract that it is about"
"""Why a message is ignored."""

Word = Award | Confirmed | GoalClosed | GoalRevised | HandoverAccepted | Release | Superseded | Withdrawn
"""What a coordinator says to its contractor. An award counts if its task is in the receiver's hands already."""


def objection(sender: str, message: Message, coordinator_of: Callable[[str, Role], str]) -> str:
    """Why a contractor ignores a word about a contract of its own; empty when it may hear it.

    Args:
        sender: whose word it is.
        message: what was said.
        coordinator_of: for a task and a role, who has given that contract; empty where there is none.
    """
    contract = contract_of(message)
    return NO_PARTY if contract is not None and coordinator_of(*contract) not in ("", sender) else ""


def contract_of(message: Message) -> tuple[str, Role] | None:
    """The contract that a coordinator speaks of: its task or goal, and the role in it; None for any other message."""
    if not isinstance(message, Word):
        return None
    if isinstance(message, GoalClosed):
        return message.goal, Role.PRIMARY
    return message.task, message.role if isinstance(message, Award | Release) else Role.PRIMARY
