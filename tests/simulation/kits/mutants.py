"""Whether the search finds a mutant, for tests."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest

from dray_sim.explore.play import play
from dray_sim.explore.run import Run

WITHIN = 40
"""Seeds in which a mutant must be found; it takes one to ten."""

Mutant = Callable[[pytest.MonkeyPatch], None]


def find(
    mutant: Mutant, drawn: Callable[[int], Run], first: int, finding: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Play runs until one tells the finding with the mutant, and nothing without it."""
    for seed in range(first, first + WITHIN):
        with monkeypatch.context() as patch:
            mutant(patch)
            found = re.search(finding, play(drawn(seed)).broken)
        if found and not play(drawn(seed)).broken:
            return
    pytest.fail(f"{WITHIN} seeds, and nothing was found")
