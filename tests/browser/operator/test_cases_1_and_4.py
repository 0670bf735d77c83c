"""The paper's cases 1 and 4 by real browsers in a running factory: a machine breaks down, and a vehicle's way is blocked.

Three tablets of one person look on, in three languages and shapes: one of them acts. Both cases are played to both of their ends: somebody
comes in time and nothing changes hands, or a person sees that it takes too long and others go on.
"""

from __future__ import annotations

import re
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from floater import OPERATOR, dray_with_floater
from frames import Frames
from playwright.sync_api import Page, expect
from tablet_kit import LYING, PHONE, UPRIGHT, settle

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]

SPEED = 10
"""Time stands while people look, and passes while somebody who was told something answers."""

SLACK_S = 150.0
"""Factory seconds that a task can be late: less, and the vehicle's patience is over before a person has read the card."""

BUSY_S = 1200
"""Within two minutes of the factory's time vehicles and machines are at work; one of which all that is asked is so comes later."""

STATION = "M8"

LOOKS: dict[str, dict[str, Any]] = {
    "en": {"viewport": LYING, "color_scheme": "light", "locale": "en-GB"},
    "de": {"viewport": UPRIGHT, "color_scheme": "dark", "locale": "de-DE"},
    "es": {"viewport": PHONE, "color_scheme": "light", "locale": "es-ES"},
}

WAY_BLOCKED = {"kind": "way_blocked", "passes": False, "needs_person": True}
BLOCKED = {"en": "the way is blocked", "de": "der Weg ist versperrt", "es": "el camino está bloqueado"}
COMES = {"en": "is on the way", "de": "unterwegs", "es": "de camino"}
GIVEN_AWAY = re.compile("Others may take them now|No goal waits for it")


@pytest.fixture(scope="module")
def dray(start_dray: Callable[..., Any], tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    with dray_with_floater(start_dray, tmp_path_factory.mktemp("cases-1-and-4"), SPEED, stepped=True) as dray:
        yield dray


class Wanted:
    """Waits for an agent of the plant of which something is so.

    Args:
        kind: "atvs" or "machines".
        is_wanted: of the agent as it is told, and of the tasks that are known.
    """

    def __init__(self, kind: str, is_wanted: Callable[[dict[str, Any], dict[str, Any]], bool]) -> None:
        self.agent: dict[str, Any] = {}
        self._kind, self._is_wanted = kind, is_wanted
        self._tasks: dict[str, dict[str, Any]] = {}

    def __call__(self, frame: dict[str, Any]) -> bool:
        self._tasks |= {task["id"]: task for task in frame.get("tasks", ())}
        for agent in frame.get(self._kind, ()):
            if not self.agent and self._is_wanted(agent, self._tasks):
                self.agent = agent
        return bool(self.agent)


def fetches_in_time(atv: dict[str, Any], tasks: dict[str, Any]) -> bool:
    """On its way to the goods, somebody watches, and its task can wait."""
    brief = atv["task"]
    task = tasks.get(brief["task"]) if brief is not None else None
    if task is None or brief["phase"] != "approaching" or not task["secondary"] or atv["problem"]:
        return False
    return ((task["deadline_at_s"] or 0.0) - (brief["due_at_s"] or 0.0)) * SPEED >= SLACK_S


def makes_what_others_can(machine: dict[str, Any], _tasks: dict[str, Any]) -> bool:
    """In the middle of a goal."""
    return (
        machine["status"] == "producing"
        and not machine["problem"]
        and any(0 < 2 * goal["made"] < goal["quantity"] for goal in machine["goals"])
    )


def busy(dray: Any, open_page: OpenPage, wanted: Wanted) -> str:
    """The next agent of which that is so."""
    watching = open_page("about:blank", visits=dray.url)
    frames = Frames(watching, wanted)
    watching.goto(dray.url)
    frames.wait_while(lambda: dray.advance(1.0), BUSY_S)
    watching.close()
    name: str = wanted.agent["id"]
    return name


@pytest.fixture
def tablets(dray: Any, open_page: OpenPage) -> dict[str, Page]:
    """By language; the first one acts."""
    return {
        language: open_page(f"{dray.url}/operator", who=OPERATOR, has_touch=True, **look)
        for language, look in LOOKS.items()
    }


def go_on_duty(tablets: dict[str, Page]) -> None:
    """A choice is that of a tab."""
    for page in tablets.values():
        on = page.locator(".duty-choices button").first
        on.tap()
        expect(on).to_have_attribute("aria-pressed", "true")


def look_at(tablets: dict[str, Page], screenshot: Screenshot, name: str, card: str) -> None:
    """Keep a picture of each, in which the card can be seen."""
    for language, page in tablets.items():
        page.locator(card).scroll_into_view_if_needed()
        screenshot(page, f"{name}-{language}")


def break_down(dray: Any, **fault: Any) -> Any:
    return dray.ask("/api/faults", fault)


def bring_back(dray: Any, fault: Any) -> None:
    """Whoever is at the vehicle or the machine has put it right."""
    path, headers = f"{dray.url}/api/faults/{fault['id']}", {"Authorization": f"Bearer {dray.token}"}
    urllib.request.urlopen(
        urllib.request.Request(path, headers=headers, method="DELETE"), timeout=60.0
    ).close()


def commands_to(dray: Any, agent: str) -> list[str]:
    """What the person has asked of it, the oldest first, as the audit log has it."""
    lines = dray.ask(f"/api/audit?target={agent}")["items"]
    return [
        line["detail"].get("kind")
        for line in reversed(lines)
        if line["who"] == OPERATOR and "kind" in line["detail"]
    ]


@pytest.mark.campaign
def test_a_vehicle_whose_way_is_blocked_is_waited_for_while_somebody_comes_and_replaced_when_nobody_can(
    dray: Any, open_page: OpenPage, tablets: dict[str, Page], screenshot: Screenshot
) -> None:
    manager, tablet = open_page(dray.url), tablets["en"]
    go_on_duty(tablets)
    wanted = Wanted("atvs", fetches_in_time)
    atv = busy(dray, open_page, wanted)
    task = wanted.agent["task"]["task"]
    fault = break_down(dray, kind="vehicle_broken", atv=atv, problem=WAY_BLOCKED)
    card, call = f"#vehicle-{atv}", tablet.locator(".call").filter(has_text=atv)
    with dray.going():
        expect(call).to_contain_text("asks you")
    with dray.going():
        call.get_by_role("button", name="I take it within 5 min").tap()
        expect(call).to_contain_text("expects you")
        for language, page in tablets.items():
            expect(page.locator(card)).to_contain_text(BLOCKED[language])
            expect(page.locator(card)).to_contain_text(COMES[language])
    look_at(tablets, screenshot, "case-4-expected", card)
    bring_back(dray, fault)
    with dray.going():
        expect(call).to_have_count(0)
    manager.goto(f"{dray.url}/#tasks")
    row = manager.get_by_role("row").filter(has_text=task)
    dray.advance_until(lambda: is_delivered(dray, task), step_s=10.0)
    expect(row).to_contain_text("delivered")
    assert dray.ask(f"/api/tasks/{task}")["primary"] == atv

    again = Wanted("atvs", fetches_in_time)
    atv = busy(dray, open_page, again)
    task, card = again.agent["task"]["task"], f"#vehicle-{atv}"
    fault = break_down(dray, kind="vehicle_broken", atv=atv, problem=WAY_BLOCKED)
    with dray.going():
        expect(tablet.locator(card).locator(".hand-over")).to_be_visible()
    settle(tablet)
    with dray.going():
        tablet.locator(card).locator(".hand-over").tap()
        expect(tablet.locator(card).locator(".hand-over")).to_contain_class("leaving")
    look_at(tablets, screenshot, "case-4-leaving", card)
    # It is sent once it cannot be taken back any more; time must not run away before that.
    expect(tablet.locator(card).locator(".command")).to_contain_text("Hand over")
    row = manager.get_by_role("row").filter(has_text=task)
    dray.advance_until(lambda: is_delivered(dray, task), step_s=10.0)
    expect(row).to_contain_text("delivered")
    assert dray.ask(f"/api/tasks/{task}")["primary"] != atv
    assert commands_to(dray, atv)[-1] == "hand_over"
    bring_back(dray, fault)


@pytest.mark.campaign
def test_a_machine_keeps_its_goals_while_somebody_mends_it_and_others_make_them_when_that_takes_too_long(
    dray: Any, open_page: OpenPage, tablets: dict[str, Page], screenshot: Screenshot
) -> None:
    tablet = tablets["en"]
    go_on_duty(tablets)
    wanted = Wanted("machines", makes_what_others_can)
    machine = busy(dray, open_page, wanted)
    fault = break_down(dray, kind="machine_broken", machine=machine)
    selector = f"#machine-{machine}"
    card, call = tablet.locator(selector), tablet.locator(".call").filter(has_text=machine)
    with dray.going():
        expect(card).to_contain_text("asks for help")
    held = {goal["goal"] for goal in told(dray, machine)["goals"]}
    with dray.going():
        call.get_by_role("button", name="I take it within 5 min").tap()
        expect(call).to_contain_text("expects you")
        for page in tablets.values():
            expect(page.locator(selector).locator(".patience")).to_contain_text(OPERATOR)
    look_at(tablets, screenshot, "case-1-promised", selector)
    bring_back(dray, fault)
    with dray.going():
        expect(card).to_have_count(0)
    goals = told(dray, machine)["goals"]
    assert held <= {goal["goal"] for goal in goals} | delivered(dray, held)
    assert not any(goal["offered"] for goal in goals)

    again = Wanted("machines", makes_what_others_can)
    machine = busy(dray, open_page, again)
    selector = f"#machine-{machine}"
    card = tablet.locator(selector)
    fault = break_down(dray, kind="machine_broken", machine=machine)
    with dray.going():
        card.locator(".hand-over").tap()
    look_at(tablets, screenshot, "case-1-leaving", selector)
    with dray.going():
        expect(card).to_contain_text(GIVEN_AWAY)
    look_at(tablets, screenshot, "case-1-offered", selector)
    assert commands_to(dray, machine)[-1] == "hand_over"
    bring_back(dray, fault)
    with dray.going():
        expect(card).to_have_count(0)


def is_delivered(dray: Any, task: str) -> bool:
    return bool(dray.ask(f"/api/tasks/{task}")["state"] == "delivered")


def told(dray: Any, machine: str) -> Any:
    return dray.ask(f"/api/machines/{machine}")


def delivered(dray: Any, goals: set[str]) -> set[str]:
    """Those of them that are done."""
    return goals - {goal["goal"] for each in dray.ask("/api/machines")["items"] for goal in each["goals"]}
