"""Each agent reacts to every change that its parts can note: a change without a reaction ends the agent by an exception."""

from __future__ import annotations

import ast
import inspect
import sys
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from types import CellType, FunctionType, MethodType
from typing import Any

import pytest

from dray.adapters.security.signing import is_signed
from dray.plant import default_plant
from dray.protocol.gate.gate import DeliveryGate
from dray.protocol.machine.machine import Machine
from dray.protocol.operator.operator import Operator
from dray.protocol.runtime.agent import AgentBase
from dray.protocol.runtime.life import Change
from dray.protocol.station.station import Station
from dray.protocol.strategist.strategist import Strategist
from dray.protocol.traffic.driving.right_of_way import RightOfWay
from dray.protocol.traffic.traffic_map import TrafficMap
from dray.protocol.vehicle.atv import Atv

PLANT = default_plant()
MACHINE, STORAGE, ATV = (next(iter(each)) for each in (PLANT.machines, PLANT.storages, PLANT.fleet))

AGENTS: Mapping[str, Callable[[TrafficMap], AgentBase]] = {
    "machine": lambda traffic: Machine(MACHINE, PLANT, traffic=traffic),
    "station": lambda traffic: Station(STORAGE, PLANT, traffic=traffic),
    "gate": lambda _traffic: DeliveryGate(PLANT),
    "strategist": lambda _traffic: Strategist(PLANT),
    "one of two strategists": lambda _traffic: Strategist(PLANT, others=("strategist-2",)),
    "operator": lambda _traffic: Operator("anna", PLANT.id),
    "vehicle": lambda traffic: Atv(ATV, PLANT, traffic=traffic),
    "vehicle without right of way": lambda _traffic: Atv(ATV, PLANT),
}

MADE_LATER: Mapping[type[AgentBase], type] = {Atv: RightOfWay}
"""Parts that an agent makes only when it starts: it does not know before where its body stands."""

PROTOCOL = "dray.protocol."


@cache
def traffic_map() -> TrafficMap:
    return TrafficMap(PLANT, is_signed)


@cache
def agent_of(name: str) -> AgentBase:
    return AGENTS[name](traffic_map())


def inside(one: Any) -> Iterator[Any]:
    """What an object refers to: attributes, elements, and what its functions are bound to."""
    match one:
        case MethodType():
            yield from (one.__self__, one.__func__)
        case FunctionType():
            yield from one.__closure__ or ()
        case CellType():
            yield one.cell_contents
        case dict():
            yield from one.values()
        case list() | tuple() | set() | frozenset():
            yield from one
        case _ if type(one).__module__.startswith(PROTOCOL):
            yield from getattr(one, "__dict__", {}).values()
            slots = {name for kind in type(one).__mro__ for name in getattr(kind, "__slots__", ())}
            yield from (getattr(one, name) for name in sorted(slots) if hasattr(one, name))


def parts_of(agent: AgentBase) -> set[type]:
    """The classes of the agent, and of all that it is made of."""
    known: dict[int, Any] = {id(agent): agent}
    to_do: list[Any] = [agent]
    while to_do:
        for each in inside(to_do.pop()):
            if id(each) not in known:
                known[id(each)] = each
                to_do.append(each)
    return {type(each) for each in known.values() if type(each).__module__.startswith(PROTOCOL)}


@cache
def methods_of(kind: type) -> Mapping[str, tuple[frozenset[type[Change]], bool]]:
    """Method that a class defines itself -> the changes that it makes, and whether it calls the method that it replaces."""
    names = vars(sys.modules[kind.__module__])
    (body,) = ast.parse(inspect.getsource(kind)).body
    assert isinstance(body, ast.ClassDef)
    found: dict[str, tuple[frozenset[type[Change]], bool]] = {}
    for method in body.body:
        if isinstance(method, ast.FunctionDef):
            calls = [each.func for each in ast.walk(method) if isinstance(each, ast.Call)]
            made = {names.get(each.id) for each in calls if isinstance(each, ast.Name)}
            changes = frozenset(each for each in made if isinstance(each, type) and issubclass(each, Change))
            found[method.name] = (
                changes,
                any(isinstance(each, ast.Name) and each.id == "super" for each in calls),
            )
    return found


def made_by(kind: type) -> set[type[Change]]:
    """The changes that an object of this class can make; replaced methods do not count."""
    above = [each for each in kind.__mro__ if each.__module__.startswith(PROTOCOL)]
    made: set[type[Change]] = set()
    for name in {name for each in above for name in methods_of(each)}:
        for each in above:
            if name in methods_of(each):
                changes, goes_on = methods_of(each)[name]
                made |= changes
                if not goes_on:
                    break
    return made


def made_in(agent: AgentBase) -> set[type[Change]]:
    parts = parts_of(agent) | {part for kind, part in MADE_LATER.items() if isinstance(agent, kind)}
    return {change for kind in parts for change in made_by(kind)}


@pytest.mark.parametrize("name", AGENTS)
def test_an_agent_reacts_to_every_change_that_its_parts_can_note(name: str) -> None:
    agent = agent_of(name)
    assert made_in(agent) - agent._reactions.keys() == set()


def test_every_kind_of_change_is_made_by_a_part_of_some_agent() -> None:
    """Otherwise this module does not see all parts, or nobody needs the change."""
    # A dataclass with slots is made twice; its module names the second.
    named = (vars(sys.modules[kind.__module__]).get(kind.__name__) for kind in Change.__subclasses__())
    all_kinds = {kind for kind in named if kind is not None and kind.__module__.startswith(PROTOCOL)}
    assert all_kinds - set().union(*(made_in(agent_of(name)) for name in AGENTS)) == set()
