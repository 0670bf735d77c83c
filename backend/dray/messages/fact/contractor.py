"""Facts of a contractor, which is a vehicle or a machine: its bids and its contracts."""

from __future__ import annotations

from dray.messages.base import Count, Id, Seconds, Text
from dray.messages.contract import Refusal
from dray.messages.fact.base import Fact
from dray.messages.heartbeat import Role
from dray.messages.kinds import BIDDERS, VEHICLES
from dray.messages.reason import Implausible, Reason


class BidSent(Fact, told_by=BIDDERS, frozen=True):
    """The vehicle or machine made a bid; the bid itself is the coordinator's fact."""

    task: Id
    epoch: Count
    role: Role
    total_s: Seconds


class BidRefused(Fact, told_by=BIDDERS, frozen=True):
    """It did not bid, and why (protocol, step 2)."""

    task: Id
    epoch: Count
    role: Role
    reason: Refusal
    detail: Text = ""


class ContractTaken(Fact, told_by=BIDDERS, frozen=True):
    """It has taken a contract."""

    task: Id
    epoch: Count
    role: Role
    coordinator: Id


class ContractEnded(Fact, told_by=BIDDERS, frozen=True):
    """It is free of this contract."""

    task: Id
    epoch: Count
    role: Role
    reason: Reason
    detail: Text = ""
    """Text for people, in the words of the agent that has held it up."""


class NotBelieved(Fact, told_by=BIDDERS, frozen=True):
    """A coordinator does not believe this agent, for this reason. At most once a minute for each coordinator."""

    by: Id
    task: Id
    reason: Implausible


class TookOver(Fact, told_by=VEHICLES, frozen=True):
    """A secondary carries the task from now on, because its primary has failed."""

    task: Id
    epoch: Count
    """The new epoch."""
    primary: Id
    """The vehicle that it replaces."""
    silent_s: Seconds
    reason: Reason
