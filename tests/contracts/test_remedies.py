"""docs/operating.md has a remedy for each alert, problem and refusal that there is, and for nothing else."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path
from typing import get_args

import pytest
from problem_kinds import problem_kinds

from dray.gateway.http.problems import AWAY
from dray.gateway.live.views.alert import AlertKind
from dray.gateway.orders.idempotency import AT_WORK
from dray.messages import ProblemKind

PAGE = (Path(__file__).parents[2] / "docs/operating.md").read_text(encoding="utf-8")

NAMED = {
    "Remedies for alerts": get_args(AlertKind),
    "Problems of vehicles and machines": [kind.value for kind in ProblemKind],
    "Refusals of the gateway": problem_kinds() | {AWAY, AT_WORK},
}
"""By the heading of its table, what code names."""


def remedies(heading: str) -> list[tuple[str, str]]:
    """The rows of a table: what is named, and its remedy."""
    (section,) = re.findall(rf"^### {heading}$(.*?)(?=^##|\Z)", PAGE, re.MULTILINE | re.DOTALL)
    return re.findall(r"^\| `([\w-]+)` \| (.*) \|$", section, re.MULTILINE)


@pytest.mark.parametrize(("heading", "named"), NAMED.items())
def test_each_has_one_remedy_and_nothing_that_is_no_more_has_one(heading: str, named: Iterable[str]) -> None:
    rows = remedies(heading)
    assert sorted(name for name, _ in rows) == sorted(named)
    assert [name for name, remedy in rows if len(remedy.split()) < 3] == []


def test_graver_alerts_come_first() -> None:
    assert [name for name, _ in remedies("Remedies for alerts")] == list(get_args(AlertKind))
