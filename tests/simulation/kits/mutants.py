"""Whether the search finds a mutant, for tests."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from typing import Any

import pytest

from dray_sim.explore.play import play
from dray_sim.explore.run import Run

WITHIN = 400
"""Seeds in which a mutant must be found. It takes one to ten where the first seed was chosen, and more where a change
of the protocol has made other runs of the seeds."""

Mutant = Callable[[pytest.MonkeyPatch], None]

Find = Callable[[Mutant, Callable[[int], Run], int, str], None]
"""Find a mutant: it, how a seed's run is drawn, the seed to begin with, and a pattern of what will be told."""


def searches(mutants: Iterable[Any], *quick: str) -> list[Any]:
    """Parameters of a test of mutants: the quick ones are for `make test-long`, the others for `make campaign`.

    Args:
        mutants: `pytest.param` of each, with its id.
        quick: ids.
    """
    every = list(mutants)
    assert set(quick) <= {mutant.id for mutant in every}, "there is no such mutant"
    marks = {True: pytest.mark.slow, False: pytest.mark.campaign}
    return [pytest.param(*each.values, id=each.id, marks=marks[each.id in quick]) for each in every]


def search(
    mutant: Mutant, drawn: Callable[[int], Run], first: int, finding: str, monkeypatch: pytest.MonkeyPatch
) -> int:
    """Play runs until one tells the finding with the mutant, and nothing without it; its seed."""
    for seed in range(first, first + WITHIN):
        with monkeypatch.context() as patch:
            mutant(patch)
            found = re.search(finding, play(drawn(seed)).broken)
        if found and not play(drawn(seed)).broken:
            return seed
    pytest.fail(f"{WITHIN} seeds from {first} on, and nothing was found")
