"""`dray bench`: benchmarks, each figure beside a baseline of the same run."""

from __future__ import annotations

import re
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from dray.cli.runtime.options import Traffic

if TYPE_CHECKING:
    from dray_sim.bench import Row


def bench(
    names: Annotated[
        list[str] | None,
        typer.Argument(help="Names of benchmarks; else all that are not long.", show_default=False),
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Less work: less exact, for a first look.")] = False,
    json: Annotated[Path | None, typer.Option(help="Write the figures here too.")] = None,
    out: Annotated[Path | None, typer.Option(help="Write them here as a Markdown document, too.")] = None,
    plant: Annotated[str, typer.Option(help="With `traffic`: this floor only.", show_default=False)] = "",
    seeds: Annotated[
        str, typer.Option(help="With `traffic`: seeds from A to before B.", metavar="A:B", show_default=False)
    ] = "",
    traffic: Traffic = None,
) -> None:
    """Run benchmarks; every figure is beside a baseline of the same run."""
    from rich.console import Console

    from dray.cli.runtime.options import right_of_way
    from dray.cli.runtime.output import one_of, table, write_text
    from dray.errors import SettingsError, UnavailableError
    from dray_sim.bench import BENCHES, DRIVEN, LONG, as_json
    from dray_sim.bench.document import document
    from dray_sim.bench.row import HEADS
    from dray_sim.bench.traffic.measure import measure as compare

    asked = names or [name for name in BENCHES if name not in LONG]
    chosen = {name: one_of(BENCHES, name, "benchmark") for name in asked}
    on = right_of_way(traffic)
    chosen |= {name: partial(DRIVEN[name], traffic=on) for name in chosen if name in DRIVEN}
    if plant or seeds:
        if names != ["traffic"]:
            raise SettingsError(
                "--plant and --seeds", "they choose runs of one benchmark; write `dray bench traffic`"
            )
        chosen = {"traffic": partial(compare, plant=plant, seeds=_range(seeds) if seeds else None)}
    rows: list[Row] = []
    progress = Console(stderr=True)
    for name, measure in chosen.items():
        try:
            with progress.status(f"measuring {name}"):
                rows += measure(quick)
        except UnavailableError as missing:
            # For all benchmarks, run all that can run here.
            if names:
                raise
            progress.print(f"{name} is left out: {missing}")
    table(HEADS, [row.cells for row in rows])
    if json is not None:
        write_text(json, as_json(rows) + "\n")
    if out is not None:
        said = [*asked, *(["--quick"] if quick else []), *(["--plant", plant] if plant else [])]
        said += ["--seeds", seeds] if seeds else []
        said += [] if traffic is None else ["--traffic" if traffic else "--no-traffic"]
        write_text(out, document(rows, " ".join(("dray bench", *said, "--out", str(out)))))


def _range(seeds: str) -> range:
    from dray.errors import SettingsError

    match = re.fullmatch(r"(\d+):(\d+)", seeds)
    if match is None or int(match[1]) >= int(match[2]):
        raise SettingsError("--seeds", f"{seeds!r} is not A:B, two whole numbers, the second one larger")
    return range(int(match[1]), int(match[2]))
