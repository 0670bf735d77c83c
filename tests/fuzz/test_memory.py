"""Whoever talks to an agent for ever does not fill its memory.

Every message type is said thousands of times, each time with new names. What an agent keeps of it must come to
an end, except where it is real work: an order, or a goal that was awarded.
"""

from __future__ import annotations

import enum
import functools
import itertools
import types
import typing
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from typing import Any

import msgspec
import pytest
from seals import granted
from situations import (
    MATERIALS,
    NAMES,
    Played,
    announcing_machine,
    carrying_vehicle,
    idle_vehicle,
    machine_with_carrier_and_watch,
    strategist_with_an_order,
)
from utterances import MESSAGE_TYPES
from variants import variants

from dray.messages import Award, Message, OrderReleased, VehicleCommand
from dray.plant import Plant
from dray.protocol.runtime.events import Agent, Received, Woke

NEW_NAMES = frozenset(
    {"task", "order", "goal", "command", "atv", "machine", "agent", "bidder", "dwell_point"}
)
"""Fields that hold another name each time; the others mean something real."""

SAID = 2400
"""More than twice what the longest history in an agent keeps (`CLOSED_KEPT`)."""

SPACING_S = 0.05

GROWTH = 1.1
"""Between half of it and all of it, at most: what is bounded has met its bound by then."""

SLACK = 300
"""Values: what is under way at any moment."""


def said(kind: type[Message], number: int) -> Message:
    """Something new; a command that counts, for others are not remembered at all."""
    message = fresh(kind, number)
    return granted("ATV1", message) if isinstance(message, VehicleCommand) else message


def fresh(kind: type[msgspec.Struct], number: int) -> Any:
    """A message or part whose names were never heard before."""
    return kind(**{name: _value(hint, name, number) for name, hint in _fields(kind)})


@functools.cache
def _fields(kind: type[msgspec.Struct]) -> list[tuple[str, Any]]:
    return [(field.name, field.type) for field in msgspec.structs.fields(kind)]


def _value(hint: Any, name: str, number: int) -> Any:
    origin, args = typing.get_origin(hint), typing.get_args(hint)
    if origin is typing.Annotated:
        return _plain(args[0], name, number)
    if origin in (typing.Union, types.UnionType):
        return _value(args[number % len(args)], name, number)
    if origin is tuple and args[-1] is not Ellipsis:
        return tuple(_value(arg, name, number) for arg in args)
    if origin is tuple:
        return (_value(args[0], name, number),)
    if origin is typing.Literal:
        return args[number % len(args)]
    if hint is type(None):
        return None
    if hint is msgspec.UnsetType:
        return msgspec.UNSET
    if hint is bool:
        return bool(number % 2)
    if issubclass(hint, enum.Enum):
        return list(hint)[number % len(hint)]
    return fresh(hint, number)


def _plain(hint: Any, name: str, number: int) -> Any:
    if hint is int:
        return number if name in ("seq", "number", "version") else 1
    if hint is float:
        return 0.5
    if hint is str:
        return f"{name}{number}" if name in NEW_NAMES else NAMES.get(name, MATERIALS)[0]
    if hint is bytes:
        return bytes(64)
    return (_value(typing.get_args(hint)[0], name, number),)


def weigh(root: Agent) -> int:
    """How many values hang on an agent."""
    seen: set[int] = set()
    open_ends: list[Any] = [root]
    weight = 0
    while open_ends:
        value = open_ends.pop()
        if id(value) in seen or isinstance(value, str | int | float | enum.Enum | Plant | type):
            continue
        seen.add(id(value))
        weight += 1
        open_ends.extend(_inside(value))
    return weight


def _inside(value: Any) -> Iterable[Any]:
    if isinstance(value, dict):
        return itertools.chain(value.keys(), value.values())
    if isinstance(value, list | tuple | set | frozenset | deque):
        return value
    if callable(value) and not hasattr(value, "__dict__"):
        return ()
    return _attributes(value)


def _attributes(value: Any) -> Iterator[Any]:
    yield from getattr(value, "__dict__", {}).values()
    for kind in type(value).__mro__:
        for name in getattr(kind, "__slots__", ()):
            if hasattr(value, name):
                yield getattr(value, name)


REAL_WORK = {("Machine", Award), ("Strategist", OrderReleased)}

SITUATIONS: tuple[Callable[[], Played], ...] = (
    idle_vehicle,
    carrying_vehicle,
    announcing_machine,
    machine_with_carrier_and_watch,
    strategist_with_an_order,
)


@pytest.mark.parametrize("situation", SITUATIONS, ids=lambda each: each.__name__)
@pytest.mark.parametrize("kind", variants(MESSAGE_TYPES, *MESSAGE_TYPES[::4]), ids=lambda each: each.__name__)
def test_an_agent_does_not_keep_all_that_it_hears(
    kind: type[Message], situation: Callable[[], Played], monkeypatch: pytest.MonkeyPatch
) -> None:
    # Its own bound would take a hundred thousand orders.
    monkeypatch.setattr("dray.protocol.strategist.order_book.ENDED_KEPT", 1000)
    actor = situation()
    agent = actor.agent
    assert agent is not None
    if (type(agent).__name__, kind) in REAL_WORK:
        return
    weights = []
    for number in range(1, SAID + 1):
        now_s = actor.now_s + number * SPACING_S
        agent.handle(Received(f"sender{number}", said(kind, number)), now_s)
        if agent.wake_at_s <= now_s:
            agent.handle(Woke(None if actor.body is None else actor.body.sense()), now_s)
        if number in (SAID // 2, SAID):
            weights.append(weigh(agent))
    assert weights[1] <= weights[0] * GROWTH + SLACK
