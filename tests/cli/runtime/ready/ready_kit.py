"""A small plant, what its gateway tells of it, and how a finding is looked at."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from dray.cli.runtime.ready.answers import Agent, Answers, Part, Picture, Silence
from dray.cli.runtime.ready.finding import Finding, Verdict
from dray.messages.keys import GATE
from dray.plant import shipped_plant

WORKSHOP = shipped_plant("workshop")
AREA = "SHOP-FLOOR"
NOW_S = 1_900_000_000.0
DAY_S = 86_400.0


def heard(agent: str, **fields: Any) -> Agent:
    return Agent(id=agent, seen_at_s=NOW_S - 1.0, silence=Silence(3.5), **fields)


def picture(**fields: Any) -> Picture:
    usual: dict[str, Any] = {
        "machines": tuple(map(heard, WORKSHOP.machines)),
        "atvs": tuple(map(heard, WORKSHOP.fleet)),
        "stations": tuple(map(heard, (*WORKSHOP.stores, GATE))),
    }
    return Picture(at_s=NOW_S, plant=WORKSHOP.id, **usual | fields)


def answers(told: Picture | None = None, **fields: Any) -> Answers:
    usual: dict[str, Any] = {"parts": {"strategist": Part(ok=True)}, "plant": {}}
    return Answers(picture=told or picture(), **usual | fields)


def of(name: str, found: Iterable[Finding]) -> Finding:
    """The finding of this name; the only one."""
    (it,) = (each for each in found if each.name == name)
    return it


def seen(finding: Finding, verdict: Verdict, words: str) -> bool:
    return finding.verdict is verdict and words in finding.seen
