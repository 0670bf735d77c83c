"""Right of way: places on the lanes, the vehicles that may drive into them, and those that make room.

A *place* is a node of the plant, or a crossing of two-lane roads. The places around a machine are its *district*. One machine at a
time leads the district's reservation table, which names the holder of each place; others keep copies (`dray.protocol.traffic`). Each
request contains all that a vehicle holds and wants in a district, and each answer all its lines of the table. So a lost, doubled or
late message only costs time.
"""

from __future__ import annotations

from collections.abc import Iterable
from enum import StrEnum
from math import floor
from typing import Annotated

import msgspec
from msgspec import UNSET, Meta, UnsetType

from dray.messages.base import Count, Id, IdOrNone, Message, Part, Seconds
from dray.messages.kinds import DOCKS, VEHICLES

ROUTE_MAX = 64
"""Maximum nodes of a way in a message: no refuge is sought farther away."""

HOLDS_MAX = 64
"""Maximum places that one vehicle holds, or wants, in one district: a few at a time in any plant."""

MISSES_MAX = 64
"""Maximum lines named at once whose release a copy misses; the others are named when these are settled."""

DISTRICT_MAX = 10_000
"""Maximum places of one district: a whole large plant that one machine keeps alone."""

NEAR_NODES = 12
"""Nodes ahead of a vehicle that count as announced traffic; its later way may change."""

Rank = tuple[Count, Seconds, Id]
"""Urgency, lowest first: class (0 with a task, 1 idle, 2 at rest), start of the present leg, id.

Time held up counts many times. Each leg begins with a new rank, so every vehicle becomes the most urgent one some day.
"""

FIRST_S = -1e11
"""Time in a rank that goes before all others."""

NO_RANK: Rank = (3, 0.0, "-")
"""The least urgent rank."""

KEY_BYTES = 32
"""An Ed25519 public key."""

MARK_BYTES = 12
"""Length of a mark, long enough that no other key with the same beginning can be found."""

Mark = Annotated[bytes, Meta(max_length=MARK_BYTES)]
"""The first bytes of the key that signs a request; empty for none. The holder of a place is identified by name and mark."""

FIRST_LIFE = 1
"""The life of a vehicle's first start: there is no word of an earlier one."""

UNSIGNED = b"unsigned"
"""Stands for the mark of requests without a key."""

Places = Annotated[tuple[Id, ...], Meta(max_length=HOLDS_MAX)]
Nodes = Annotated[tuple[Id, ...], Meta(max_length=2 * ROUTE_MAX)]


class Blocked(StrEnum):
    """Why a vehicle was not granted all that it wants."""

    NO = "no"
    """It was granted, or it wants nothing."""
    WAIT = "wait"
    """Another vehicle holds a place of it, or goes first."""
    DOCKED = "docked"
    """The holder of a place of it stands at a dock, and stays."""
    SILENT = "silent"
    """The holder of a place of it is silent."""


class PlaceRequested(Message, said_by=VEHICLES, radio=True, frozen=True):
    """All that a vehicle holds and wants in a district. Repeated until `PlaceGranted` answers it."""

    district: Id
    life: Count
    """The vehicle's incarnation: with a new one, all its lines of the table are granted anew."""
    seq: Count
    """Grows with every request of one life."""
    epoch: Count
    """Epoch of the table, as far as the vehicle knows."""
    rank: Rank
    """Its own, or the inherited one of a vehicle for which it makes room."""
    holds: Places
    groups: Annotated[tuple[Places, ...], Meta(max_length=HOLDS_MAX)]
    """The groups that it wants next, in the order of its way. Each is granted whole, and after those ahead of it."""
    seen: Count
    """The highest grant number in this district that the vehicle has seen; 0 while it requests the place where it stands."""
    stands: bool
    """Whether it stands and waits for what it wants."""
    docked: bool
    """Whether it stands at a dock, and stays there until its work is done."""
    avoid: Nodes = ()
    """Nodes where no vehicle may make room: its way, and the ways of those for which it makes room."""
    chain: Places = ()
    """The vehicles for which it makes room, in order."""
    removal: Count = 0
    """Number of its newest removal, as far as it knows (`dray.messages.floor.removal`)."""
    renews: Count = 0
    """The highest grant number that it has seen, while it requests the place where it stands: it may have given that back, so its lines of
    `groups` up to this number are granted anew."""
    key: Annotated[bytes, Meta(max_length=KEY_BYTES)] = b""
    """The vehicle's public key, made at its first start: its certificate alone does not speak for its places. Empty for none."""
    signature: Annotated[bytes, Meta(max_length=64)] = b""
    """Ed25519 by that key, over `request_words`."""

    @property
    def mark(self) -> bytes:
        """The mark of its key."""
        return self.key[:MARK_BYTES]


class PlaceReservation(Part, frozen=True):
    """A line of a reservation table: a place and its holder."""

    place: Id
    number: Count
    """Number of the grant. Numbers of one district only grow, also when the leader changes."""
    atv: IdOrNone = ""
    """The holder; empty in messages to that vehicle itself."""
    mark: Mark = b""
    """Mark of the key whose requests can give it back; empty when any request of that vehicle can."""


PlaceReservations = Annotated[tuple[PlaceReservation, ...], Meta(max_length=DISTRICT_MAX)]


def line_beyond(reservations: Iterable[PlaceReservation], version: int) -> str:
    """Describes the first line of a table whose number is above its version; empty when there is none."""
    for at, line in enumerate(reservations):
        if line.number > version:
            return f"`number` {line.number} is above `version` {version} - at `$.reservations[{at}].number`"
    return ""


def _check_lines(table: TableReplicated | TableReported) -> None:
    """Refuse a table with grants of the future: its reader would take later grants for old ones.

    Raises:
        ValueError: a line's number is above the version.
    """
    if fault := line_beyond(table.reservations, table.version):
        raise ValueError(fault)


class Removed(Part, frozen=True):
    """A removal that a table knows: the vehicle's lines from before it are struck out."""

    atv: Id
    number: Count
    mark: Mark = b""
    """Mark of the key, or `UNSIGNED`, if the vehicle reported it itself: then only lines of that mark are meant. Empty if people did."""


AllRemoved = Annotated[tuple[Removed, ...], Meta(max_length=DISTRICT_MAX)]


class PlaceGranted(Message, said_by=DOCKS, radio=True, frozen=True):
    """All lines of one vehicle in the table: the answer to every request, and sent anew after each grant."""

    district: Id
    epoch: Count
    life: Count
    """The vehicle's life that is meant."""
    upto: Count
    """Number of its newest known request."""
    grants: PlaceReservations
    blocked: Blocked = Blocked.NO
    by: IdOrNone = ""
    """The vehicle in the way."""
    at: IdOrNone = ""
    """The place where it is in the way."""
    removal: Count = 0
    """Number of the vehicle's newest removal known to the table: earlier grants are void."""
    mark: Mark = b""
    """Mark of the answered requests, or `UNSIGNED`: vehicles with another key are not meant. Empty when all of that name are."""


class PlaceConfirmed(Message, said_by=DOCKS, radio=True, frozen=True):
    """The witness, which is the replica whose turn is next, confirms a vehicle's lines of its copy: a grant needs this confirmation.

    Sent when it has copied new lines, and to a vehicle that sends its request to it.
    """

    district: Id
    epoch: Count
    grants: PlaceReservations
    """All lines of that vehicle, with the mark of its key; when `life` is set, only those under the key that has said so."""
    life: Count | UnsetType = UNSET
    """The vehicle's newest life that the witness knows by its signed request; unset for the first life and for requests without a
    key. A later life believes no other confirmation: from then on the witness believes no release by an earlier life."""
    polled: Count | UnsetType = UNSET
    """Epoch of the recovery poll from whose table the witness's copy comes. Told to a vehicle that has seen a higher number than the
    copy's: without this it believes no lower numbers."""


class OnFloor(Part, frozen=True):
    """A vehicle that holds places in a district: a hint for others' prices of ways and refuges, which grants no rights."""

    atv: Id
    holds: Places
    """Its places in this district."""
    stands: bool
    """Whether it may not drive anywhere at present."""
    docked: bool
    """Whether it stays where it stands until its work there is done."""
    silent: bool
    """Whether it is unknown when it moves again: its heartbeats have stopped, or it waits for a person's help."""
    rank: Rank
    route: Annotated[tuple[Id, ...], Meta(max_length=NEAR_NODES)]
    """Its node, and the next ones of its way."""


class FloorReported(Message, said_by=DOCKS, frozen=True):
    """The leader of a table reports the vehicles in its district to all that drive there or nearby.

    Sent after changes, at most twice a second, and again every few seconds while there is a vehicle.
    """

    district: Id
    epoch: Count
    number: Count
    """Grows with every report of one epoch."""
    vehicles: Annotated[tuple[OnFloor, ...], Meta(max_length=DISTRICT_MAX)]


class YieldAsked(Message, said_by=DOCKS, radio=True, frozen=True):
    """A replica asks the holder of a place to make room; the holder decides whether it does."""

    district: Id
    waiting: Id
    """The vehicle that needs the place."""
    rank: Rank
    avoid: Nodes
    """Nodes where the holder would be in the way again."""
    chain: Places
    """The vehicles for which `waiting` itself makes room, in order."""


class YieldRefused(Message, said_by=VEHICLES, radio=True, frozen=True):
    """The sender has no refuge: the receiver must make room itself."""

    avoid: Nodes
    """The sender's node, and its way."""
    holds: Places


class HoldsAsked(Message, said_by=DOCKS, radio=True, frozen=True):
    """A replica reports the table's epoch, as after a change of the leader, and asks for the places that the vehicle holds."""

    district: Id
    epoch: Count
    recovery_poll: bool = False
    """Whether the table is lost: places that are not reported now are free, and grants of earlier epochs are void."""
    misses: Count | UnsetType = UNSET
    """Highest number of the vehicle's lines whose release a copy misses (`TableAsked.misses`). When leader and witness have both told
    it, the vehicle counts all grants up to it as seen, and its answer is that release."""


class GivenBack(Part, frozen=True):
    """A vehicle's signed request, which proves what it gives back."""

    atv: Id
    request: PlaceRequested
    """Without `avoid`, which is not signed."""


AllGivenBack = Annotated[tuple[GivenBack, ...], Meta(max_length=DISTRICT_MAX)]


class TableReplicated(Message, said_by=DOCKS, frozen=True):
    """The whole reservation table of a district, for the replicas that keep copies. A grant counts when a majority has it."""

    district: Id
    epoch: Count
    version: Count
    """The highest number given so far: no line has a higher one."""
    reservations: PlaceReservations
    removed: AllRemoved = ()
    given_back: AllGivenBack = ()
    """Releases that struck lines out: replicas refuse a table that takes a place from a vehicle without its release."""

    def __post_init__(self) -> None:
        _check_lines(self)


class TableAcknowledged(Message, said_by=DOCKS, frozen=True):
    """A replica has copied the table up to this version; a higher epoch means that another replica leads."""

    district: Id
    epoch: Count
    version: Count


class TableAsked(Message, said_by=DOCKS, frozen=True, omit_defaults=True):
    """A replica asks others for their copies: it wants to lead the district's table, has lost its own, checks who lives, or refuses one."""

    district: Id
    epoch: Count
    """The epoch under which it wants to lead; 0 when it only asks."""
    misses: Annotated[tuple[PlaceReservation, ...], Meta(max_length=MISSES_MAX)] = ()
    """Lines of the sender's copy that the leader has struck out, while the sender misses their vehicles' releases: the receiver is
    to ask these vehicles. One line for each key, with its highest number."""


class TableReported(Message, said_by=DOCKS, frozen=True):
    """A replica's copy of the table, and the epoch that it follows, or under which it wants to lead."""

    district: Id
    epoch: Count
    lost: bool
    """Whether it has no copy: it was started for the first time, or has lost its memory."""
    kept_epoch: Count
    """Epoch under which the copy was written."""
    version: Count
    """The highest number given so far: no line has a higher one."""
    reservations: PlaceReservations
    removed: AllRemoved = ()
    began: Count = 0
    """Epoch of the table that it copied after it had lost its memory, in this life; 0 when it had not."""

    def __post_init__(self) -> None:
        _check_lines(self)


def request_words(atv: str, request: PlaceRequested) -> bytes:
    """The bytes that a request's signature covers: a JSON array without white space, times as whole thousandths.

    `avoid` is left out: it is a hint, and is shortened when a request goes by radio. So is `renews`: it gives nothing back.

    Args:
        atv: the vehicle that sends it.
        request: the request; its `signature` is ignored.
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
