"""Vehicles that people have carried away, or are putting back: the places that they held are free.

Only a vehicle itself gives back its places (`dray.messages.floor.traffic`). A dead or switched-off one cannot, so a person who has
carried it away reports that in its place. A gateway repeats the report as long as the vehicle is silent.

A gateway may know an older heartbeat than others do: it was cut off, or has begun since. So a report also tells when the person made
it (`ReportTime`). An agent whose newest word of the vehicle came before that accepts the report all the same.

*Removals* of one vehicle are numbered. Places held under a lower number are void for all agents that know the higher one, the
vehicle included. So a late or doubled report frees nothing that the vehicle has been granted since.
"""

from __future__ import annotations

from math import floor
from typing import Annotated

import msgspec
from msgspec import UNSET, Meta, UnsetType

from dray.messages.base import Count, Id, IdOrNone, Message, Part, Seconds
from dray.messages.kinds import GATEWAYS
from dray.messages.people.command import Grant

MAX_REMOVALS = 64
"""Maximum removals in one message; more of them take several messages."""


class ReportTime(Part, frozen=True):
    """When a person made a report. It has a signature of its own, so that agents which do not know it can examine the rest."""

    at_s: Seconds
    """When the person made it (the signer's clock)."""
    signed_s: Seconds
    """When this was signed (the same clock). It tells an agent how far its own clock is behind."""
    signature: Annotated[bytes, Meta(min_length=64, max_length=64)]
    """Ed25519, over `reported_words`."""


class Removal(Part, frozen=True):
    """A person's report of one vehicle: it is off the floor, or is being put back at a node."""

    atv: Id
    number: Count
    """Grows with every report of this vehicle: its time, in milliseconds of unix time, or one more than the one before."""
    life: Count
    """With `seq`: the vehicle's last known heartbeat. An agent that has heard a later one refuses the report, unless that one came
    before the report."""
    seq: Count
    grant: Grant
    node: IdOrNone = ""
    """Where it is being put back: the place is reserved for it. Empty while it is off the floor."""
    reported: ReportTime | UnsetType = UNSET
    """When it was made; left out when only the named heartbeat tells that."""


class Removals(Message, said_by=GATEWAYS, frozen=True):
    """Vehicles that are off the floor, or being put back. It says nothing about other vehicles."""

    removals: Annotated[tuple[Removal, ...], Meta(max_length=MAX_REMOVALS)]


def removed_words(removal: Removal) -> bytes:
    """The bytes that its grant's signature covers: a JSON array without white space, seconds as whole thousandths."""
    grant = removal.grant
    return _encoder.encode(
        (
            "dray removal 1",
            removal.atv,
            removal.number,
            removal.life,
            removal.seq,
            removal.node,
            grant.person,
            grant.areas,
            grant.everywhere,
            floor(grant.valid_until_s * 1000.0 + 0.5),
        )
    )


def reported_words(removal: Removal, reported: ReportTime) -> bytes:
    """The bytes that the signature of a report's time covers: a JSON array without white space, seconds as whole thousandths.

    They contain the grant's signature in base64: the time belongs to one publication of the report, and to no later one.

    Args:
        removal: the report with its signed grant; its `reported` is ignored.
        reported: the time; its `signature` is ignored.
    """
    times = (floor(time_s * 1000.0 + 0.5) for time_s in (reported.at_s, reported.signed_s))
    return _encoder.encode(
        ("dray removal time 1", removal.atv, removal.number, removal.grant.signature, *times)
    )


_encoder = msgspec.json.Encoder()
