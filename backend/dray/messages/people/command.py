"""People's commands to vehicles and machines, and the grants that they come with.

Neither obeys anybody's bare word. Every command carries a *grant*: on whose behalf it is given, in which
areas that person may command, and until when. The signature binds the grant to one command for one
agent, so that it says nothing about any other.
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
"""Areas that one grant can name: more than anybody answers for who is not given the whole plant."""

STOP_MARGIN_M = 2.0
"""How far outside of an area a vehicle may still be stopped by who answers for that area.

A person stops what the tablet shows. Its picture of a working vehicle is up to a second old, and the command
is under way for a moment; meanwhile a vehicle at 1.5 m/s drives 2 m, and a stop must not be lost to that.
"""

PROMISE_MAX_S = 900.0
"""The longest `wait_s` of a promise. A person who has promised to come is waited for that long and no longer, since a
promise may be forgotten."""


OUT_MAX_S = 30 * 86_400.0
"""Longer than a month nobody knows when a vehicle or a machine will be back."""


class CommandKind(StrEnum):
    """What a person may ask of a vehicle (paper, case 5)."""

    STOP = "stop"
    ACKNOWLEDGE = "acknowledge"
    """The fault is gone."""
    RESUME = "resume"
    """Go on: only after an acknowledge."""
    SET_SPEED = "set_speed"
    PROMISE = "promise"
    """Help is on the way: keep the task for as long as was promised (paper, case 4)."""
    HAND_OVER = "hand_over"
    """It cannot be mended there: let another vehicle carry its task at once (paper, case 4)."""
    CHARGE = "charge"
    """Charge after the present work, as full as it is ever charged, and take no work before that."""
    TAKE_OUT = "take_out"
    """Take no work until somebody puts it into service again: it is to be mended or looked after (paper, 4.3)."""
    PUT_IN = "put_in"
    """Take work again: it was out of service, or sent to charge."""

    @property
    def margin_m(self) -> float:
        """How far outside of an area it still reaches from within."""
        return STOP_MARGIN_M if self is CommandKind.STOP else 0.0


class Grant(Part, frozen=True):
    """Who asks, where that person may, and until when. Good for the command that it comes with only."""

    person: Id
    """On whose behalf the command is given."""
    valid_until_s: Seconds
    """Later than this (plant clock) nobody obeys it."""
    signature: Annotated[bytes, Meta(min_length=64, max_length=64)]
    """Ed25519, over `signed_words`."""
    areas: Annotated[tuple[Id, ...], Meta(max_length=MAX_AREAS)] = ()
    """The areas of the plant in which that person may command."""
    everywhere: bool = False
    """In all of the plant, whatever areas there are."""


class VehicleCommand(Message, said_by=GATEWAYS, radio=True, frozen=True):
    """A person's command to one vehicle."""

    command: Id
    """Names this command, so that its answer can be told from others."""
    kind: CommandKind
    speed_frac: Fraction | None = None
    """For SET_SPEED: 0 to 1 of the vehicle's own top speed."""
    wait_s: Seconds | None = None
    """For PROMISE: how long from now the help will take, `PROMISE_MAX_S` at most. For TAKE_OUT: how long it is expected to be out of
    service, `OUT_MAX_S` at most; None where nobody knows."""
    reason: Text = ""
    """For TAKE_OUT: why."""
    after_work: bool = False
    """For TAKE_OUT: what it carries it brings to its end first. Else it gives back what is not on board yet."""
    issued_by: Text = ""
    """Whom the vehicle names when it tells of the command; what counts is the grant."""
    grant: Grant | None = None
    """Without one it is refused."""


class MachineCommandKind(StrEnum):
    """What a person may ask of a machine (paper, case 1)."""

    PROMISE = "promise"
    """Help is on the way: keep the goals for as long as was promised."""
    CLEAR_FAULT = "clear_fault"
    """The fault is gone: work again."""
    HAND_OVER = "hand_over"
    """It cannot be mended in time: let other machines make its goals now."""
    SET_SPEED = "set_speed"
    """Work more slowly, or as fast as it can again."""
    RESTART = "restart"
    """Start its agent again."""
    UPDATE = "update"
    """Start its agent again with the newer software that lies ready."""
    TAKE_OUT = "take_out"
    """Take no goals until somebody puts it into service again."""
    PUT_IN = "put_in"
    """Take goals again."""
    FETCH_GOODS = "fetch_goods"
    """Goods on board of a vehicle that has failed can be handed over: have another one fetch them there."""
    WRITE_OFF = "write_off"
    """They cannot: make them again."""
    LOAD_THERE = "load_there"
    """Somebody has looked: the load of a transport that is held is where it was to go."""
    LOAD_MISSING = "load_missing"
    """It is not: have it fetched or made again."""
    ARRIVED = "arrived"
    """Pieces have come, with a vehicle or by hand. This and the four below are *words*: they tell a machine whose body is people what has happened."""
    TAKEN = "taken"
    """Pieces have gone."""
    MADE = "made"
    """Good pieces are finished."""
    SCRAPPED = "scrapped"
    """Pieces came out bad: they lie nowhere."""
    STOCK_IS = "stock_is"
    """Somebody has counted what lies there of one item."""

    @property
    def is_about_goods(self) -> bool:
        """Whether it is about goods on board of a failed vehicle, and is granted for the place where those are."""
        return self in (MachineCommandKind.FETCH_GOODS, MachineCommandKind.WRITE_OFF)

    @property
    def is_about_held(self) -> bool:
        """Whether it is about the load of a transport that is held, and is granted for the place where that was to go."""
        return self in (MachineCommandKind.LOAD_THERE, MachineCommandKind.LOAD_MISSING)

    @property
    def names_task(self) -> bool:
        """Whether it is about one transport."""
        return self.is_about_goods or self.is_about_held

    @property
    def is_word(self) -> bool:
        """Whether it tells a machine what has happened. A word may be sent again under its name: it counts once."""
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
    """A person's command to one machine. A station obeys those about transports that are held, too."""

    command: Id
    """Names this command, so that its answer can be told from others."""
    kind: MachineCommandKind
    speed_frac: Fraction | None = None
    """For SET_SPEED: 0 to 1 of its own speed."""
    wait_s: Seconds | None = None
    """For PROMISE: how long from now the help will take, `PROMISE_MAX_S` at most. For TAKE_OUT: how long it is expected to be out of
    service, `OUT_MAX_S` at most; None where nobody knows."""
    reason: Text = ""
    """For TAKE_OUT: why."""
    after_work: bool = False
    """For TAKE_OUT: the goal that it works at it finishes first."""
    task: IdOrNone = ""
    """For FETCH_GOODS, WRITE_OFF, LOAD_THERE and LOAD_MISSING: the transport whose load is meant."""
    node: IdOrNone = ""
    """For FETCH_GOODS: where they are handed over; empty for the nearest node beside the vehicle."""
    item: IdOrNone = ""
    """For words: the material or product; empty for the product that is being made."""
    quantity: Count = 0
    """For words: pieces."""
    vehicle: IdOrNone = ""
    """For ARRIVED and TAKEN: who has brought or fetched them; empty for by hand."""
    sure: bool = False
    """For words: the number is right, however far it is from the expected one."""
    issued_by: Text = ""
    """Whom the machine names when it tells of the command; what counts is the grant."""
    grant: Grant | None = None
    """Without one it is refused."""


class CommandAnswered(Message, said_by=BIDDERS | STATIONS | GATES, radio=True, frozen=True):
    """The word of whom a command was given to: done, or refused with a reason."""

    command: Id
    done: bool
    reason: CommandRefusal | None = None
    """None when it was done."""
    detail: Text = ""
    """What its sensors still report, or what does not support the command, where that is the reason."""


def signed_words(agent: str, command: VehicleCommand | MachineCommand, grant: Grant) -> bytes:
    """What the signature of a grant covers: a JSON array without white space, the same for the same command.

    Its numbers are whole thousandths, which every language writes alike.

    Args:
        agent: the vehicle or machine that is to obey.
        command: what is asked; its own `grant` is not looked at.
        grant: its `signature` is not looked at.
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
    """Halves are rounded up, by arithmetic that is the same in all languages; what no wire can carry says nothing."""
    return None if value is None or not isfinite(value) else floor(value * 1000.0 + 0.5)
