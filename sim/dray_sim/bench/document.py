"""A document of the figures that one command has measured, beside their baselines and aims.

docs/benchmarks.md is put together by hand from such documents.
"""

from __future__ import annotations

import os
import platform
from collections.abc import Iterable, Sequence

from dray_sim.bench.row import HEADS, Row


def document(rows: Sequence[Row], command: str) -> str:
    """The document.

    Args:
        rows: in the order in which they were measured.
        command: the command that measured and wrote them.
    """
    aims = [row for row in rows if row.target is not None]
    missed = sum(not row.met for row in aims)
    head = [
        "# Benchmarks",
        "",
        f"Made by `{command}`; do not edit. Measured with Python {platform.python_version()} on {os.cpu_count()} processors. What is measured in",
        "virtual time (`traffic`) is the same on every computer; rates are not: their ratio to a baseline of the same run is.",
        "",
        f"{len(rows)} figures, {len(aims)} with an aim, {missed} of which are missed.",
        "",
    ]
    return (
        "\n".join([*head, _line(HEADS), _line("---" for _ in HEADS), *(_line(row.cells) for row in rows)])
        + "\n"
    )


def _line(cells: Iterable[str]) -> str:
    return f"| {' | '.join(cell.replace('|', '/') for cell in cells)} |"
