"""Searches for a mutant, and tells the campaign's ledger which seeds it took."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from mutants import Find, Mutant, search

from dray_sim.explore.run import Run


@pytest.fixture
def find(monkeypatch: pytest.MonkeyPatch, record_property: Callable[[str, object], None]) -> Find:
    """See `mutants.search`."""

    def find(mutant: Mutant, drawn: Callable[[int], Run], first: int, finding: str) -> None:
        last = search(mutant, drawn, first, finding, monkeypatch)
        record_property("seeds", f"{mutant.__name__} {first} to {last}")

    return find
