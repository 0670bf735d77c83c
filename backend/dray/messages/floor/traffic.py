"""Right of way: places on the lanes, who may drive into them, and who makes room.

A *place* is a node of the plant, or a crossing of two-lane roads. The places around a machine are its *district*; one machine
at a time keeps the district's reservation table, which says by whom each of them is held, and others keep copies (`dray.protocol.traffic`). A
vehicle says in each request all that it holds and wants in a district, and is answered with all that the table says of it. So a lost, doubled or late
message costs time, and nothing else.
"""

from __future__ import annotations

from collections.abc import Iterable
from enum import StrEnum
from math import floor
from typing import Annotated

import msgspec
from msgspec import Meta

from dray.messages.base import Count, Id, IdOrNone, Message, Part, Seconds
from dray.messages.kinds import DOCKS, VEHICLES

ROUTE_MAX = 64
"""Nodes of a way that are told: nobody looks farther ahead for a place to make room."""

HOLDS_MAX = 64
"""Places that one vehicle holds, or wants, in one district: a few at a time in any plant."""

DISTRICT_MAX = 10_000
"""Places of one district: those of a whole large plant that one machine keeps alone."""

NEAR_NODES = 12
"""So far ahead a vehicle's way counts as announced traffic: what it does later may change."""

Rank = tuple[Count, Seconds, Id]
"""Who goes first; the lower the more urgent: class (0 with a task, 1 idle, 2 at rest), since when it is on this leg, its id.

Time that it has stood for others counts many times. A new leg brings a new rank, so everybody is the most urgent one some day.
"""

FIRST_S = -1e11
"""Instead of the time in a rank: before everybody, whenever they have begun."""

NO_RANK: Rank = (3, 0.0, "-")
"""Behind everybody."""

KEY_BYTES = 32
"""An Ed25519 public key."""

MARK_BYTES = 12
"""Of a key: nobody finds another one that begins alike."""

Mark = Annotated[bytes, Meta(max_length=MARK_BYTES)]
"""The first bytes of the key by which a request is signed; empty for none. Who holds a place is a vehicle by its name and this."""

UNSIGNED = b"unsigned"
"""Stands for the mark where a word is about requests without a key."""

Places = Annotated[tuple[Id, ...], Meta(max_length=HOLDS_MAX)]
Nodes = Annotated[tuple[Id, ...], Meta(max_length=2 * ROUTE_MAX)]


class Blocked(StrEnum):
    """Why a vehicle was not granted all that it wants."""

    NO = "no"
    """It was granted, or it wants nothing."""
    WAIT = "wait"
    """Somebody holds a place of it, or goes first."""
    DOCKED = "docked"
    """Somebody who holds a place of it stands at a dock, and stays."""
    SILENT = "silent"
    """Nobody has heard of its holder for a while."""


class PlaceRequested(Message, said_by=VEHICLES, radio=True, frozen=True):
    """All that a vehicle holds and wants in a district. Answered with `PlaceGranted`, and repeated until it is."""

    district: Id
    life: Count
    """The vehicle's incarnation: with a new one everything that the table says of it is granted anew."""
    seq: Count
    """Grows with every request of one life."""
    epoch: Count
    """Of the table, as far as the vehicle knows."""
    rank: Rank
    """Its own, or the one of whom it makes room for."""
    holds: Places
    groups: Annotated[tuple[Places, ...], Meta(max_length=HOLDS_MAX)]
    """Wanted next, in the order of the way. Each is granted whole, and none before those ahead of it."""
    seen: Count
    """The highest number of a grant in this district that the vehicle has seen."""
    stands: bool
    """It stands, and waits for what it wants."""
    docked: bool
    """It stands at a dock, and stays there until its work is done."""
    avoid: Nodes = ()
    """Where nobody may make room: the way of this vehicle, and of those whom it makes room for."""
    chain: Places = ()
    """The vehicles whom it makes room for, the first one first."""
    removal: Count = 0
    """The newest time that it was carried away, as far as it knows (`dray.messages.floor.removal`)."""
    key: Annotated[bytes, Meta(max_length=KEY_BYTES)] = b""
    """The vehicle's own, drawn at its first start and never given away: its certificate alone does not speak for its places. Empty for none."""
    signature: Annotated[bytes, Meta(max_length=64)] = b""
    """Ed25519 by that key, over `request_words`."""

    @property
    def mark(self) -> bytes:
        """That of its key."""
        return self.key[:MARK_BYTES]


class PlaceReservation(Part, frozen=True):
    """A line of a reservation table: by whom a place is held."""

    place: Id
    number: Count
    """Of the grant. Numbers of one district only grow, whoever keeps its table."""
    atv: IdOrNone = ""
    """Empty where it is said to that vehicle itself."""
    mark: Mark = b""
    """Only requests under this key give it back; empty where any of that vehicle does."""


PlaceReservations = Annotated[tuple[PlaceReservation, ...], Meta(max_length=DISTRICT_MAX)]


def line_beyond(reservations: Iterable[PlaceReservation], version: int) -> str:
    """What is wrong with a reservation table: the first line under a number that it has not given yet, in words; empty for nothing."""
    for at, line in enumerate(reservations):
        if line.number > version:
            return f"`number` {line.number} is above `version` {version} - at `$.reservations[{at}].number`"
    return ""


def _check_lines(table: TableReplicated | TableReported) -> None:
    """Refuse a reservation table that names grants of the future: its reader would take what is granted then for old.

    Raises:
        ValueError: a line's number is above the version.
    """
    if fault := line_beyond(table.reservations, table.version):
        raise ValueError(fault)


class Removed(Part, frozen=True):
    """A vehicle of which a reservation table knows that it was carried away: what it held under a lower number is struck out."""

    atv: Id
    number: Count
    mark: Mark = b""
    """The vehicle has said so itself, under this key or `UNSIGNED`: it is about what is held under it alone. Empty where people have said so."""


AllRemoved = Annotated[tuple[Removed, ...], Meta(max_length=DISTRICT_MAX)]


class PlaceGranted(Message, said_by=DOCKS, radio=True, frozen=True):
    """All that the table says of one vehicle: the answer to every request, and said anew when something is granted."""

    district: Id
    epoch: Count
    life: Count
    """Of the vehicle; other ones are not meant."""
    upto: Count
    """The number of its newest request that is known."""
    grants: PlaceReservations
    blocked: Blocked = Blocked.NO
    by: IdOrNone = ""
    """Who is in the way."""
    at: IdOrNone = ""
    """The place that is held by it."""
    removal: Count = 0
    """The newest time that the vehicle was carried away, as the table knows: whatever it was granted before is void."""
    mark: Mark = b""
    """Of the requests that are answered, or `UNSIGNED`: whoever has another key is not meant. Empty where all of that name are."""


class PlaceConfirmed(Message, said_by=DOCKS, radio=True, frozen=True):
    """The witness of a reservation table, the replica whose turn is next, has these lines of one vehicle in its copy: no grant is believed without.

    Said when it has written new ones, and to a vehicle that asks by sending its request to it.
    """

    district: Id
    epoch: Count
    grants: PlaceReservations
    """All of that vehicle, with the mark of its key."""


class OnFloor(Part, frozen=True):
    """A vehicle that holds something in a district, for others' prices of ways and places to make room: a hint, and no right to anything."""

    atv: Id
    holds: Places
    """In this district."""
    stands: bool
    """It may not drive anywhere at present."""
    docked: bool
    """It stays where it stands until its work is done there."""
    silent: bool
    """Nobody knows when it moves again: it was not heard for a while, or stands until a person has seen to it."""
    rank: Rank
    route: Annotated[tuple[Id, ...], Meta(max_length=NEAR_NODES)]
    """The node where it is and the next ones of its way."""


class FloorReported(Message, said_by=DOCKS, frozen=True):
    """What the leader of a reservation table knows of the vehicles in its district: to all that drive there or close by.

    Said when it has changed, twice a second at most, and again every few seconds while there is a vehicle.
    """

    district: Id
    epoch: Count
    number: Count
    """Grows with every word of one epoch."""
    vehicles: Annotated[tuple[OnFloor, ...], Meta(max_length=DISTRICT_MAX)]


class YieldAsked(Message, said_by=DOCKS, radio=True, frozen=True):
    """The holder of a place is asked to make room. Whether it does is its own decision."""

    district: Id
    waiting: Id
    """For whom."""
    rank: Rank
    avoid: Nodes
    """Where it would be in the way again."""
    chain: Places
    """Those whom `waiting` itself makes room for, the first one first."""


class YieldRefused(Message, said_by=VEHICLES, radio=True, frozen=True):
    """There is nowhere to go: make room yourself."""

    avoid: Nodes
    """Where the sender is and wants to go."""
    holds: Places


class HoldsAsked(Message, said_by=DOCKS, radio=True, frozen=True):
    """The table of a district is kept by somebody else from now on: tell it what you hold, as a request."""

    district: Id
    epoch: Count
    recovery_poll: bool = False
    """The table is lost: what is not told now is not held. Grants of earlier epochs count for nothing from now on."""


class GivenBack(Part, frozen=True):
    """A vehicle's own word, as it has signed it: what it gives back."""

    atv: Id
    request: PlaceRequested
    """Without `avoid`, which is not signed."""


class TableReplicated(Message, said_by=DOCKS, frozen=True):
    """The whole reservation table of a district, for those who keep a copy. A grant counts when a majority has it."""

    district: Id
    epoch: Count
    version: Count
    """The highest number that was given: no line has a higher one."""
    reservations: PlaceReservations
    removed: AllRemoved = ()
    given_back: Annotated[tuple[GivenBack, ...], Meta(max_length=DISTRICT_MAX)] = ()
    """By which lines were struck out that counted before: nobody copies a reservation table that takes a place from a vehicle without its word."""

    def __post_init__(self) -> None:
        _check_lines(self)


class TableAcknowledged(Message, said_by=DOCKS, frozen=True):
    """A copy is kept up to this version; with a higher epoch: somebody else keeps the table."""

    district: Id
    epoch: Count
    version: Count


class TableAsked(Message, said_by=DOCKS, frozen=True):
    """Somebody means to keep the table of a district, or has lost its copy: what have you?"""

    district: Id
    epoch: Count
    """Under which it means to keep the table; 0 for one that only wants to know."""


class TableReported(Message, said_by=DOCKS, frozen=True):
    """The copy that somebody has, and the epoch by which it goes, or under which it means to keep the table itself."""

    district: Id
    epoch: Count
    lost: bool
    """It knows nothing: it lives for the first time, or has lost its memory."""
    kept_epoch: Count
    """Of the one who has written the copy."""
    version: Count
    """The highest number that was given: no line has a higher one."""
    reservations: PlaceReservations
    removed: AllRemoved = ()
    began: Count = 0
    """The epoch of the table that it copied when it had lost its memory, in this life; 0 where it had not."""

    def __post_init__(self) -> None:
        _check_lines(self)


def request_words(atv: str, request: PlaceRequested) -> bytes:
    """What the signature of a request covers: a JSON array without white space, a time as whole thousandths.

    Not `avoid`, which is a hint and is cut where a request goes by radio.

    Args:
        atv: who says it.
        request: its `signature` is not looked at.
    """
    rank_class, since_s, whose = request.rank
    return _encoder.encode(
        (
            "dray place request 1",
            atv,
            request.district,
            request.life,
            request.seq,
            request.epoch,
            (rank_class, floor(since_s * 1000.0 + 0.5), whose),
            request.holds,
            request.groups,
            request.seen,
            request.stands,
            request.docked,
            request.chain,
            request.removal,
        )
    )


_encoder = msgspec.json.Encoder()
