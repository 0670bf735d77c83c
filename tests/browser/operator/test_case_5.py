"""The paper's case 5 on both panels: a load shifts, and nobody moves before people have seen to it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from floater import OPERATOR, dray_with_floater
from frames import Frames
from playwright.sync_api import Page, expect
from tablet_kit import settle

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]

SPEED = 10
"""Time stands while people look, and passes while somebody who was told something answers."""

SLACK_S = 110.0
"""Factory seconds that the task can be late: a load that has shifted is usually seen to in 90 s, and a task that cannot wait so long
goes to another vehicle at once."""

LOADED_S = 600
"""The first vehicle has a load after a minute of the factory's time, and one whose task can wait soon after."""

TABLET = {"width": 1024, "height": 768}

HOLD_MS = 1200
"""Longer than Resume has to be held."""


@pytest.fixture(scope="module")
def dray(start_dray: Callable[..., Any], tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    with dray_with_floater(start_dray, tmp_path_factory.mktemp("case-5"), SPEED, stepped=True) as dray:
        yield dray


class Loaded:
    """Waits for a vehicle that has just set off with its load, and whose task can wait for people."""

    def __init__(self) -> None:
        self.atv: dict[str, Any] = {}
        self._before: dict[str, str] = {}
        self._deadline_at_s: dict[str, float] = {}

    def __call__(self, frame: dict[str, Any]) -> bool:
        self._deadline_at_s |= {task["id"]: task["deadline_at_s"] or 0.0 for task in frame.get("tasks", ())}
        for atv in frame.get("atvs", ()):
            phase = atv["task"]["phase"] if atv["task"] else ""
            if phase == "carrying" and self._before.get(atv["id"]) == "loading":
                slack_s = self._deadline_at_s.get(atv["task"]["task"], 0.0) - (atv["task"]["due_at_s"] or 0.0)
                if slack_s * SPEED >= SLACK_S:
                    self.atv = atv
            self._before[atv["id"]] = phase
        return bool(self.atv)


@pytest.mark.slow
def test_a_load_shifts_and_an_operator_stops_puts_right_acknowledges_and_resumes(
    dray: Any, open_page: OpenPage, screenshot: Screenshot
) -> None:
    manager, loaded = open_page("about:blank", visits=dray.url), Loaded()
    frames = Frames(manager, loaded)
    manager.goto(dray.url)
    operator = open_page(f"{dray.url}/operator", who=OPERATOR, viewport=TABLET, has_touch=True)
    frames.wait_while(lambda: dray.advance(1.0), LOADED_S)
    atv, task = loaded.atv["id"], loaded.atv["task"]["task"]
    finder = manager.get_by_role("combobox", name="Find")
    finder.fill(atv)
    expect(manager.locator("#finder-list").get_by_role("option").first).to_contain_text(atv)
    finder.press("Enter")
    overview = manager.locator(".card.atv")
    overview.get_by_role("button", name="Faults").click()
    manager.get_by_role("button", name="Shift its load").click()
    expect(overview.get_by_role("button", name="Bring back: load shifted")).to_be_visible()
    card = operator.locator(f"#vehicle-{atv}")
    with dray.going():
        expect(overview).to_contain_text("the load has shifted")
        expect(card).to_contain_text("asks for help")
    expect(card).to_contain_text("the load has shifted")
    settle(operator)
    with dray.going():
        card.get_by_role("button", name="I am on my way").last.tap()
        expect(card).to_contain_text("is on the way")
    expect(overview).to_contain_text("is on the way")

    with dray.going():
        operator.locator(f"#stop-{atv}").tap()
        expect(card.locator(".command")).to_contain_text("confirmed by the vehicle")
    acknowledge, resume = (card.get_by_role("button", name=name) for name in ("Fault is gone", "Resume"))
    expect(acknowledge).to_be_disabled()
    screenshot(operator, "case-5-stopped")
    manager.get_by_role("button", name="Bring back: load shifted").click()
    expect(overview).not_to_contain_text("Bring back")
    with dray.going():
        expect(acknowledge).to_be_enabled()
    expect(resume).to_be_disabled()
    with dray.going():
        card.get_by_role("button", name="At most 50").tap()
        expect(card.locator(".command")).to_contain_text("Speed 50 %")
        expect(card.locator(".command")).to_contain_text("confirmed by the vehicle")
        acknowledge.tap()
        expect(resume).to_be_enabled()
    resume.scroll_into_view_if_needed()
    box = resume.bounding_box()
    assert box is not None
    operator.mouse.move(box["x"] + 20, box["y"] + 20)
    operator.mouse.down()
    operator.wait_for_timeout(HOLD_MS)
    with dray.going():
        operator.mouse.up()
        expect(acknowledge).to_have_count(0)
    screenshot(operator, "case-5-resumed")

    manager.goto(f"{dray.url}/#tasks")
    row = manager.get_by_role("row").filter(has_text=task)
    dray.advance_until(lambda: dray.ask(f"/api/tasks/{task}")["state"] == "delivered", step_s=10.0)
    expect(row).to_contain_text("delivered")
    assert dray.ask(f"/api/tasks/{task}")["primary"] == atv
    told = [line for line in dray.ask(f"/api/audit?target={atv}")["items"] if line["result"] == "done"]
    given = [line["detail"].get("kind") for line in reversed(told) if line["action"] == "vehicle.command"]
    assert given == ["promise", "stop", "set_speed", "acknowledge", "resume"]
    assert {line["who"] for line in told if line["action"] == "vehicle.command"} == {OPERATOR}
