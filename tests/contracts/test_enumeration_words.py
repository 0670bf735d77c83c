"""No enumeration reaches people raw: every member that panels look up by its name has words in every language.

What panels say by `t` is checked by the compiler; `word` looks a name up that the gateway has chosen, and falls back to the name.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Mapping
from enum import Enum
from pathlib import Path
from typing import Any, get_args, get_type_hints

import pytest
from msgspec.structs import fields
from problem_kinds import OF_PROGRAMS, problem_kinds

from dray.gateway.access.principal import Over, Role
from dray.gateway.http.fault_codes import CODES
from dray.gateway.http.problems import AWAY
from dray.gateway.live.projection.auctions.why import ASKED, LATE, QUEUE, SILENT
from dray.gateway.live.replay.recorder import MarkKind
from dray.gateway.live.views import (
    AlertKind,
    AtvView,
    MachineView,
    OrderView,
    RemovalRefusalView,
    TaskView,
    WhyView,
)
from dray.gateway.live.views.duty import DutyChoice
from dray.gateway.orders.wanted_vehicle import Unwilling
from dray.messages import (
    CallAnswer,
    ClosureKind,
    CommandKind,
    CommandRefusal,
    MachineCommandKind,
    Phase,
    ProductionCost,
    Refusal,
    TransportCost,
)
from dray.messages.people.operator import DutyStatus
from dray.messages.problem import ProblemKind
from dray.messages.reason import Implausible, Reason
from dray.protocol.vehicle import status_report
from dray.protocol.vehicle.people.command_handling import ALONE, DENIED, DOUBLED
from dray.protocol.vehicle.people.problem_handling import NO_WLAN
from dray.store.replay.spells import AtvDoing, MachineDoing
from dray_sim.bodies.vehicle.condition import BATTERY_EMPTY, LOAD_SHIFTED
from dray_sim.faults.kinds import KIND_NAMES

FRONTEND = Path(__file__).parents[2] / "frontend" / "src"

LANGUAGES = ("en", "de", "es")


def literals(kind: Any) -> set[str]:
    """The members of an enumeration, however it is written."""
    if isinstance(kind, type) and issubclass(kind, Enum):
        return {str(each.value) for each in kind}
    found: set[str] = set()
    for each in get_args(kind):
        found |= {each} if isinstance(each, str) else literals(each)
    return found - {""}


def of(view: type, name: str) -> set[str]:
    """Those of a field of a view."""
    return literals(get_type_hints(view)[name])


COSTS = (TransportCost, ProductionCost)

PRICE_PARTS = {each.name.removesuffix("_s") for cost in COSTS for each in fields(cost)} | {"reliability"}
"""Of a bid: what its bidder reckons, and what its coordinator adds."""

SHOWN: Mapping[str, Iterable[str]] = {
    "alertLog.is": literals(AlertKind),
    "carry.refused": of(RemovalRefusalView, "reason"),
    "answer": literals(Refusal) | {ASKED, LATE, QUEUE, SILENT},
    "atv": of(AtvView, "status"),
    "machine": of(MachineView, "status") | {"lost"},
    "order": of(OrderView, "status"),
    "priority": of(OrderView, "priority"),
    "problem": problem_kinds() - OF_PROGRAMS | {AWAY, "unknown"},
    "rowFault": CODES,
    "state": of(TaskView, "state"),
    "phase": literals(Phase),
    "reason.why": literals(Reason) | literals(Implausible),
    "reason": literals(Refusal),
    "refusal": literals(Refusal),
    "refusal.command": literals(CommandRefusal),
    "why.tie": of(WhyView, "tie_by"),
    "help.kind": literals(ProblemKind),
    "duty.status": literals(DutyStatus),
    "audit.value": literals(CommandKind)
    | literals(MachineCommandKind)
    | literals(CallAnswer)
    | literals(ClosureKind)
    | literals(DutyChoice)
    | literals(Over)
    | of(OrderView, "priority"),
    "person.role": literals(Role) | {"admin", "key"},
    "part": PRICE_PARTS,
    "why.part": PRICE_PARTS,
    "doing": literals(AtvDoing) | literals(MachineDoing),
    "mark": literals(MarkKind),
    "fault.now": set(KIND_NAMES),
    "unwilling": literals(Unwilling) | literals(Refusal),
}


@pytest.mark.parametrize("part", sorted(PRICE_PARTS))
def test_every_part_of_a_price_has_a_look_in_the_bars(part: str) -> None:
    assert f".part-{part}" in (FRONTEND / "styles/cards/auction.css").read_text(encoding="utf-8")


def texts(language: str) -> dict[str, str]:
    """All that panels say in a language."""
    said: dict[str, str] = {}
    for path in sorted((FRONTEND / "text").rglob("*.ts")):
        if language in (path.stem, path.parent.name):
            said |= re.findall(r'"([\w.-]+)": "((?:[^"\\]|\\.)*)"', path.read_text(encoding="utf-8"))
    return said


@pytest.mark.parametrize("language", LANGUAGES)
@pytest.mark.parametrize("group", SHOWN)
def test_every_member_of_what_panels_show_has_words(group: str, language: str) -> None:
    assert SHOWN[group], "there is something to be said"
    said = texts(language)
    assert {member for member in SHOWN[group] if not said.get(f"{group}.{member}")} == set()


def words_of_vehicles() -> set[str]:
    """What a vehicle, and a simulated body, say in words of their own, and not by a kind."""
    tree = ast.parse(Path(status_report.__file__).read_text(encoding="utf-8"))
    constants = [node.value for node in ast.walk(tree) if isinstance(node, ast.Return)]
    said = {
        each.value for node in constants if node for each in ast.walk(node) if isinstance(each, ast.Constant)
    }
    return {each for each in said if isinstance(each, str) and " " in each} | {
        NO_WLAN,
        DOUBLED,
        DENIED,
        ALONE,
        LOAD_SHIFTED,
        BATTERY_EMPTY,
    }


@pytest.mark.parametrize("language", LANGUAGES)
def test_panels_know_what_vehicles_say_in_words_of_their_own(language: str) -> None:
    text = (FRONTEND / "text" / "shared" / f"{language}.ts").read_text(encoding="utf-8")
    assert {each for each in words_of_vehicles() if f'"failure.{each}": ' not in text} == set()
