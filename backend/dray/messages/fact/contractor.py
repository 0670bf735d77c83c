"""What a contractor tells, vehicle or machine: its bids, and what it is bound by."""

from __future__ import annotations

from dray.messages.base import Count, Id, Seconds, Text
from dray.messages.contract import Refusal
from dray.messages.fact.base import Fact
from dray.messages.heartbeat import Role


class BidSent(Fact, frozen=True):
    """The vehicle or machine made a bid; the bid itself is the coordinator's fact."""

    task: Id
    epoch: Count
    role: Role
    total_s: Seconds


class BidRefused(Fact, frozen=True):
    """It did not bid, and why (protocol, step 2)."""

    task: Id
    epoch: Count
    role: Role
    reason: Refusal
    detail: Text = ""


class ContractTaken(Fact, frozen=True):
    """It is bound now."""

    task: Id
    epoch: Count
    role: Role
    coordinator: Id


HANDED_OVER = "handed_over"
"""Why a contract has ended (`ContractEnded.reason`) that was done well."""


class ContractEnded(Fact, frozen=True):
    """It is free of this contract: `handed_over`, `released`, `resigned`, `superseded`, `withdrawn`."""

    task: Id
    epoch: Count
    role: Role
    reason: Text


class NotBelieved(Fact, frozen=True):
    """A coordinator has said that it does not believe this agent, and why. Told once a minute of each."""

    by: Id
    task: Id
    reason: Text


class TookOver(Fact, frozen=True):
    """A secondary carries the task from now on, because its primary has failed."""

    task: Id
    epoch: Count
    """The new one."""
    primary: Id
    """Whom it replaces."""
    silent_s: Seconds
    reason: Text
