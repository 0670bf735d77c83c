"""Which messages about a contract count: those of its coordinator only.

A contractor checks each message here first. Messages about a dock count from the dock's owner, a machine or a
storage's station (`atv`). Coordinators check messages of contractors themselves: they answer an unknown sender,
because it may be a replaced carrier.
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

NO_PARTY = "a message about a contract by an agent that is no party to it"
"""Reason for ignoring a message."""

Word = Award | Confirmed | GoalClosed | GoalRevised | HandoverAccepted | Release | Superseded | Withdrawn
"""A coordinator's messages to its contractor. An award counts if the receiver has its task already."""


def objection(sender: str, message: Message, coordinator_of: Callable[[str, Role], str]) -> str:
    """Why a contractor ignores a message about its own contract; empty if it may handle it.

    Args:
        sender: the sender's id.
        message: the message.
        coordinator_of: for a task and a role, the coordinator of that contract; empty if there is none.
    """
    contract = contract_of(message)
    return NO_PARTY if contract is not None and coordinator_of(*contract) not in ("", sender) else ""


def contract_of(message: Message) -> tuple[str, Role] | None:
    """The contract that a coordinator's message is about: task or goal, and role; None for other messages."""
    if not isinstance(message, Word):
        return None
    if isinstance(message, GoalClosed):
        return message.goal, Role.PRIMARY
    return message.task, message.role if isinstance(message, Award | Release) else Role.PRIMARY
