"""Vehicles that people have carried away, or are putting back: whatever they held of the floor is free.

Only a vehicle itself gives back what it holds (`dray.messages.floor.traffic`). One that is dead or switched off cannot; so a person who has
carried it away says so in its place. A gateway says the word again and again, for as long as the vehicle is silent.

*Removals* of one vehicle are numbered. What it held under a lower number is void for whoever knows the higher one, the vehicle too; so a
word that comes late, or twice, frees nothing that the vehicle has been granted since.
"""

from __future__ import annotations

from math import floor
from typing import Annotated

import msgspec
from msgspec import Meta

from dray.messages.base import Count, Id, IdOrNone, Message, Part
from dray.messages.kinds import GATEWAYS
from dray.messages.people.command import Grant

MAX_REMOVALS = 64
"""In one message; whoever has more of them says several."""


class Removal(Part, frozen=True):
    """A person's word about one vehicle: it is off the floor, or is being put back at a node."""

    atv: Id
    number: Count
    """Grows with every such word about this vehicle: its time, in milliseconds of unix time, or one more than the one before."""
    life: Count
    """With `seq`: the last heartbeat that was heard of it. Whoever has heard a later one does not believe the word."""
    seq: Count
    grant: Grant
    node: IdOrNone = ""
    """Where it is being put back: the place is kept for it. Empty while it is off the floor."""


class Removals(Message, said_by=GATEWAYS, frozen=True):
    """Vehicles that are off the floor, or on their way back to it. Who is not named is not meant."""

    removals: Annotated[tuple[Removal, ...], Meta(max_length=MAX_REMOVALS)]


def removed_words(removal: Removal) -> bytes:
    """What the signature of its grant covers: a JSON array without white space, numbers of seconds as whole thousandths."""
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


_encoder = msgspec.json.Encoder()
