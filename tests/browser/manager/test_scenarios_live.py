"""Cases and experiments that `dray up --scenario` plays, in the real panel: the card tells all steps, and the claim holds (paper, 4.2 and 4.3)."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Page, expect
from variants import in_campaigns

from dray_sim.scenarios import LIVE

OpenPage = Callable[..., Page]
Screenshot = Callable[..., Path]

SPEED = 100

PLAYED_S = 6 * 3600.0
"""Of the factory's time: case-6 goes on for more than four hours."""


SOON = ("case-3", "experiment-power-off")
"""The others are played without a panel in `tests/simulation/scenarios/test_scenarios.py`, where every step is looked at, too."""


@pytest.mark.timeout(1800)
@pytest.mark.parametrize("name", in_campaigns(sorted(LIVE), *SOON))
def test_a_scenario_is_played_to_its_end_and_its_card_tells_every_step(
    start_dray: Callable[..., Any], open_page: OpenPage, screenshot: Screenshot, name: str
) -> None:
    dray = start_dray("--scenario", name, "--speed", str(SPEED), stepped=True)
    page = open_page(dray.url)
    card = page.locator(".scenario")
    expect(card).to_contain_text(name)
    ended = card.get_by_role("status").filter(has_text="after")
    dray.advance_until(ended.count, PLAYED_S, step_s=30.0)
    screenshot(page, f"scenario-live-{name}")
    expect(card.get_by_role("status")).to_contain_text("Held")
    expect(card.locator("li.todo")).to_have_count(0)
    assert dray.stop() == 0, dray.output()
