"""People's commands to vehicles and machines, and their grants.

Neither obeys a command without a grant. A *grant* names the person who commands, the areas in which that person may, and until when.
Its signature binds it to one command for one agent, so that it is valid for no other.
"""

from __future__ import annotations

from enum import StrEnum
from math import floor, isfinite
from typing import Annotated

import msgspec
from msgspec import Meta

from dray.messages.base import Count, Fraction, Id, IdOrNone, Message, Part, Seconds, Text
from dray.messages.kinds import BIDDERS, GATES, GATEWAYS, STATIONS
from dray.messages.reason import CommandRefusal

MAX_AREAS = 64
"""Maximum areas of one grant: more than a person has who may not command in the whole plant."""

STOP_MARGIN_M = 2.0
"""Distance outside an area within which a person of that area may still stop a vehicle.

A person stops the vehicle that the tablet shows. That picture is up to a second old, and the command takes a moment. Meanwhile a
vehicle at 1.5 m/s drives 2 m, and the stop must still count.
"""

PROMISE_MAX_S = 900.0
"""Longest `wait_s` of a promise. No longer wait is useful, since people may forget a promise."""


OUT_MAX_S = 30 * 86_400.0
"""Longest time out of service: a month. No longer one can be foreseen."""


class CommandKind(StrEnum):
    """What a person may ask of a vehicle (paper, case 5)."""

    STOP = "stop"
    ACKNOWLEDGE = "acknowledge"
    """The fault is gone."""
    RESUME = "resume"
    """Continue; only after an acknowledge."""
    SET_SPEED = "set_speed"
    PROMISE = "promise"
    """Help is on the way: keep the task for the promised time (paper, case 4)."""
    HAND_OVER = "hand_over"
    """It cannot be repaired there: let another vehicle carry its task at once (paper, case 4)."""
    CHARGE = "charge"
    """Charge to the highest level after the present work, and take no work before that."""
    TAKE_OUT = "take_out"
    """Take no work until a person puts it into service again, as for a repair (paper, 4.3)."""
    PUT_IN = "put_in"
    """Take work again, after a time out of service or a command to charge."""

    @property
    def margin_m(self) -> float:
        """Distance outside an area within which the command still counts."""
        return STOP_MARGIN_M if self is CommandKind.STOP else 0.0


class Grant(Part, frozen=True):
    """A person's right to one command: the person, the areas, and the end of its validity."""

    person: Id
    """The person who commands."""
    valid_until_s: Seconds
    """When it expires (plant clock)."""
    signature: Annotated[bytes, Meta(min_length=64, max_length=64)]
    """Ed25519, over `signed_words`."""
    areas: Annotated[tuple[Id, ...], Meta(max_length=MAX_AREAS)] = ()
    """The areas of the plant in which that person may command."""
    everywhere: bool = False
    """Whether that person may command in the whole plant."""


class VehicleCommand(Message, said_by=GATEWAYS, radio=True, frozen=True):
    """A person's command to one vehicle."""

    command: Id
    """Names this command, so that its answer can be told from others."""
    kind: CommandKind
    speed_frac: Fraction | None = None
    """For SET_SPEED: 0 to 1 of the vehicle's own top speed."""
    wait_s: Seconds | None = None
    """For PROMISE: time until help comes, `PROMISE_MAX_S` at most. For TAKE_OUT: expected time out of service, `OUT_MAX_S` at most;
    None when unknown."""
    reason: Text = ""
    """For TAKE_OUT: the reason."""
    after_work: bool = False
    """For TAKE_OUT: whether it finishes its task first. Otherwise it gives back a task whose load is not on board yet."""
    issued_by: Text = ""
    """Name that the vehicle gives when it reports the command; the right comes from the grant."""
    grant: Grant | None = None
    """Without a grant the command is refused."""


class MachineCommandKind(StrEnum):
    """What a person may ask of a machine (paper, case 1)."""

    PROMISE = "promise"
    """Help is on the way: keep the goals for the promised time."""
    CLEAR_FAULT = "clear_fault"
    """The fault is gone: work again."""
    HAND_OVER = "hand_over"
    """It cannot be repaired in time: let other machines make its goals now."""
    SET_SPEED = "set_speed"
    """Work more slowly, or as fast as it can again."""
    RESTART = "restart"
    """Start its agent again."""
    UPDATE = "update"
    """Start its agent again with the newer software that is ready."""
    TAKE_OUT = "take_out"
    """Take no goals until a person puts it into service again."""
    PUT_IN = "put_in"
    """Take goals again."""
    FETCH_GOODS = "fetch_goods"
    """Goods on board of a failed vehicle can be handed over: have another vehicle fetch them there."""
    WRITE_OFF = "write_off"
    """Goods on board of a failed vehicle cannot be handed over: make them again."""
    LOAD_THERE = "load_there"
    """The load of a held transport was found at its destination, or a doubtful load at its place."""
    LOAD_MISSING = "load_missing"
    """The load of a held transport is not at its destination: have it fetched or made again. Where carriers fail: the dock is in
    order, have it carried. Or a doubtful load is not at its place."""
    ARRIVED = "arrived"
    """Pieces have come, with a vehicle or by hand. This and the four below are *words*: reports to a machine whose body is people."""
    TAKEN = "taken"
    """Pieces have gone."""
    MADE = "made"
    """Good pieces are finished."""
    SCRAPPED = "scrapped"
    """Pieces came out bad, and are not in stock."""
    STOCK_IS = "stock_is"
    """A person has counted the stock of one item."""

    @property
    def is_about_goods(self) -> bool:
        """Whether it is about goods on board of a failed vehicle; its grant must cover their position."""
        return self in (MachineCommandKind.FETCH_GOODS, MachineCommandKind.WRITE_OFF)

    @property
    def is_about_held(self) -> bool:
        """Whether it is about a held transport or a doubtful load; its grant must cover the place where a person looks."""
        return self in (MachineCommandKind.LOAD_THERE, MachineCommandKind.LOAD_MISSING)

    @property
    def names_task(self) -> bool:
        """Whether it is about one transport."""
        return self.is_about_goods or self.is_about_held

    @property
    def is_word(self) -> bool:
        """Whether it reports an event to a machine. Such a word may be sent again under its name, and counts once."""
        return self in WORDS


WORDS = frozenset(
    {
        MachineCommandKind.ARRIVED,
        MachineCommandKind.TAKEN,
        MachineCommandKind.MADE,
        MachineCommandKind.SCRAPPED,
        MachineCommandKind.STOCK_IS,
    }
)


class MachineCommand(Message, said_by=GATEWAYS, frozen=True):
    """A person's command to one machine. A station obeys those about held transports and doubtful loads, too."""

    command: Id
    """Names this command, so that its answer can be told from others."""
    kind: MachineCommandKind
    speed_frac: Fraction | None = None
    """For SET_SPEED: 0 to 1 of its own speed."""
    wait_s: Seconds | None = None
    """For PROMISE: time until help comes, `PROMISE_MAX_S` at most. For TAKE_OUT: expected time out of service, `OUT_MAX_S` at most;
    None when unknown."""
    reason: Text = ""
    """For TAKE_OUT: the reason."""
    after_work: bool = False
    """For TAKE_OUT: whether it finishes its present goal first."""
    task: IdOrNone = ""
    """For FETCH_GOODS, WRITE_OFF, LOAD_THERE and LOAD_MISSING: the transport whose load is meant, or the name of a doubtful load."""
    node: IdOrNone = ""
    """For FETCH_GOODS: the node where they are handed over; empty for the nearest node beside the vehicle."""
    item: IdOrNone = ""
    """For words: the material or product; empty for the product that is being made."""
    quantity: Count = 0
    """For words: pieces."""
    vehicle: IdOrNone = ""
    """For ARRIVED and TAKEN: the vehicle that has brought or fetched them; empty for by hand."""
    sure: bool = False
    """For words: whether the number is right even if it is far from the expected one."""
    issued_by: Text = ""
    """Name that the machine gives when it reports the command; the right comes from the grant."""
    grant: Grant | None = None
    """Without a grant the command is refused."""


class CommandAnswered(Message, said_by=BIDDERS | STATIONS | GATES, radio=True, frozen=True):
    """The answer to a command: done, or refused with a reason."""

    command: Id
    done: bool
    reason: CommandRefusal | None = None
    """None when it was done."""
    detail: Text = ""
    """Details of the reason: what its sensors still report, or what does not support the command."""


def signed_words(agent: str, command: VehicleCommand | MachineCommand, grant: Grant) -> bytes:
    """The bytes that a grant's signature covers: a JSON array without white space, the same for the same command.

    Its numbers are whole thousandths, which every language writes alike.

    Args:
        agent: the vehicle or machine that must obey.
        command: the command; its own `grant` is ignored.
        grant: the grant; its `signature` is ignored.
    """
    words: tuple[object, ...] = (
        "dray command 2" if isinstance(command, VehicleCommand) else "dray machine command 1",
        agent,
        command.command,
        command.kind.value,
        _thousandths(command.speed_frac),
        _thousandths(command.wait_s),
        command.issued_by,
        grant.person,
        grant.areas,
        grant.everywhere,
        _thousandths(grant.valid_until_s),
    )
    if command.kind in (CommandKind.TAKE_OUT, MachineCommandKind.TAKE_OUT):
        words += (command.reason, command.after_work)
    if isinstance(command, MachineCommand) and command.kind.names_task:
        words += (command.task, command.node)
    if isinstance(command, MachineCommand) and command.kind.is_word:
        words += (command.item, command.quantity, command.vehicle, command.sure)
    return _encoder.encode(words)


_encoder = msgspec.json.Encoder()


def _thousandths(value: float | None) -> int | None:
    """Round to thousandths, halves up, with the same arithmetic in all languages; None for infinities and NaN, too."""
    return None if value is None or not isfinite(value) else floor(value * 1000.0 + 0.5)
