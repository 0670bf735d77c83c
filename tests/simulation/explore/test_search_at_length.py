"""The campaign of the search: no run breaks, with right of way, in block after block of seeds."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from dray_sim.explore.search import search

FIRST = 300_000
"""Seeds that no earlier search has played."""

BLOCK = 25
"""Two to five minutes of one core: as much is lost at most when a campaign is ended."""

BLOCKS = 80
"""2,000 seeds."""


@pytest.mark.campaign
@pytest.mark.parametrize("first", range(FIRST, FIRST + BLOCK * BLOCKS, BLOCK))
def test_no_run_breaks(first: int, record_property: Callable[[str, object], None]) -> None:
    summary = search(first, first + BLOCK, traffic=True)
    record_property("seeds", f"{first} to {first + BLOCK - 1}")
    assert [found.replay for found in summary.violations] == []
