"""A check that names the messages it hears is asked about no other ones, so it must name all that it looks at."""

from __future__ import annotations

import ast
import inspect
from collections.abc import Iterator
from importlib import import_module
from pkgutil import walk_packages
from textwrap import dedent

import pytest

import dray_sim.checks
from dray.messages import Event, HelpCall, Message, StationHeartbeat
from dray.messages.fact import MemoryLost
from dray_sim.checks.invariants import Invariants
from dray_sim.explore import play


def checks() -> Iterator[type]:
    """All classes that name what they hear."""
    found = walk_packages(dray_sim.checks.__path__, f"{dray_sim.checks.__name__}.")
    for module in (*(import_module(each.name) for each in found), play):
        for kind in vars(module).values():
            if inspect.isclass(kind) and kind.__module__ == module.__name__ and hasattr(kind, "hears"):
                yield kind


CHECKS = sorted(checks(), key=lambda check: check.__name__)


def looked_at(check: type) -> set[str]:
    """The types with which `on_message` compares the message."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(dedent(inspect.getsource(check.on_message)))):  # type: ignore[attr-defined]
        if isinstance(node, ast.Compare) and ast.unparse(node.left) == "type(message)":
            names |= {ast.unparse(kind) for kind in node.comparators}
        elif isinstance(node, ast.Call) and ast.unparse(node.func) == "isinstance":
            what, kinds = node.args
            if ast.unparse(what) == "message":
                names |= {each.id for each in ast.walk(kinds) if isinstance(each, ast.Name)}
    return names


@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.__name__)
def test_a_check_hears_all_that_it_looks_at(check: type) -> None:
    hears = check.hears  # type: ignore[attr-defined]
    assert all(issubclass(kind, Message) for kind in hears)
    assert looked_at(check) == {kind.__name__ for kind in hears}


def test_most_checks_name_what_they_hear() -> None:
    assert len(CHECKS) >= 20


class Heard:
    """A check that notes which messages it was asked about."""

    def __init__(self, *hears: type[Message]) -> None:
        self.heard: list[str] = []
        if hears:
            self.hears = hears

    def on_message(self, _at_s: float, _sender: str, _address: str, message: Message) -> None:
        self.heard.append(type(message).__name__)


def test_one_that_names_nothing_is_asked_about_everything(watched) -> None:
    invariants = Invariants(watched.factory)
    events, everything, late = Heard(Event), Heard(), Heard(HelpCall)
    invariants.add(events)
    invariants.add(everything)
    fact = Event(agent="M1", incarnation=1, number=1, at_s=0.0, fact=MemoryLost(reason="x"))
    beat = StationHeartbeat(station="W1", incarnation=1, seq=1, at_s=0.0)
    for message in (fact, beat):
        invariants.on_message(0.0, "M1", "", message)
    assert events.heard == ["Event"]
    assert everything.heard == ["Event", "StationHeartbeat"]

    invariants.add(late)
    invariants.on_message(0.0, "M1", "", fact)
    assert late.heard == []
    assert events.heard == ["Event", "Event"]
