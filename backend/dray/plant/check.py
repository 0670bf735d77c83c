"""How the entries of a plant file must fit together."""

from __future__ import annotations

from collections.abc import Iterator

from dray.plant.model import PlantFile


def faults(file: PlantFile) -> Iterator[tuple[str, str]]:
    """Every fault."""
    yield from ()
