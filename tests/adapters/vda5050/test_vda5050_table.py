"""docs/vehicles.md says what is: its table of behaviours names tests that are there, its drawing is that of the states."""

from __future__ import annotations

import re
from pathlib import Path
from urllib.parse import urlsplit

import pytest

from dray.adapters.vda5050.control.order_state import ACTIVE, OVER, TRANSITIONS, OrderState
from dray.states import diagram

ROOT = Path(__file__).parents[3]
DOCUMENT = (ROOT / "docs/vehicles.md").read_text(encoding="utf-8")

BEHAVIOURS, WAITS, VALUES = "What the driver does", "What it waits for", "Values that cannot be"
"""How the sections with a table of tests begin."""


def written() -> set[str]:
    """Of the driver, by their names."""
    return {
        name
        for file in Path(__file__).parent.glob("test_*.py")
        for name in re.findall(r"^def (test_\w+)", file.read_text(encoding="utf-8"), re.MULTILINE)
    }


def rows(section: str) -> list[tuple[str, str, str]]:
    """Of a section's table: what stands first in each row, its test, and where it was reported."""
    (text,) = (each for each in DOCUMENT.split("\n## ") if each.startswith(section))
    return re.findall(r"^\| (.*?) \| .* \| `(test_\w+)` \| ?(.*?) ?\|$", text, re.MULTILINE)


def test_each_of_the_25_behaviours_has_tests_and_each_of_them_is_listed() -> None:
    listed = rows(BEHAVIOURS)
    assert [int(number) for number, _, _ in listed] == list(range(1, 26))
    for number, test, _ in listed:
        assert test.startswith(f"test_{int(number):02}_")
        assert test in written()


def test_each_thing_that_is_waited_for_and_each_value_that_is_doubted_has_a_test() -> None:
    waited, doubted = rows(WAITS), rows(VALUES)
    assert (len(waited), len(doubted)) == (21, 14)
    assert {test for _, test, _ in waited + doubted} <= written()


@pytest.mark.parametrize("section", [BEHAVIOURS, WAITS, VALUES])
def test_a_report_is_a_link_and_what_it_says_and_the_sentence_below_counts_them(section: str) -> None:
    found = rows(section)
    reports = [report for _, _, report in found if report]
    for report in reports:
        link = re.fullmatch(r"\[[\w .-]+\]\((\S+)\): \S.*", report)
        assert link is not None, report
        place = urlsplit(link[1])
        assert (place.scheme, place.netloc) == ("https", "github.com"), report
        assert re.fullmatch(r"/[\w.-]+/[\w.-]+/(issues|pull)/\d+", place.path), report
        assert not place.query
        assert not place.fragment
    assert f"\n{len(reports)} of these {len(found)} rows have a report.\n" in DOCUMENT


def test_at_least_twenty_rows_were_reported_in_public() -> None:
    found = rows(BEHAVIOURS) + rows(WAITS) + rows(VALUES)
    assert sum(bool(report) for _, _, report in found) >= 20
    assert len({report for _, _, report in found if report}) >= 20


def test_what_is_newer_than_what_is_followed_says_why() -> None:
    (text,) = (each for each in DOCUMENT.split("\n## ") if each.startswith("What is newer"))
    newer = re.findall(r"^\| (?!in the text|---)(.*) \| (.*) \|$", text, re.MULTILINE)
    assert len(newer) >= 20
    for what, how in newer:
        assert how.startswith(("followed", "by the profile: ", "no cause: ")) or ", because " in how, what


def test_the_drawing_of_the_states_is_that_of_the_table() -> None:
    assert diagram(TRANSITIONS) in DOCUMENT


def test_every_state_is_left_for_one_of_the_table_and_all_lead_to_an_end() -> None:
    assert set(TRANSITIONS) == set(OrderState)
    assert {state for state, row in TRANSITIONS.items() if not row} == OVER
    ends = set(OVER)
    while more := {state for state, row in TRANSITIONS.items() if ends & row.keys()} - ends:
        ends |= more
    assert ends == set(OrderState)
    assert set(OrderState) - OVER > ACTIVE
