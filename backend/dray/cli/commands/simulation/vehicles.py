"""`dray sim vehicles`: kills and restarts around vehicles that speak VDA 5050."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from dray.cli.runtime.options import Traffic


def vehicles(
    kills: Annotated[
        int, typer.Option(help="Number of kills, one every 20 s on average.", min=1, max=10_000)
    ] = 200,
    seed: Annotated[int, typer.Option(help="Seed of everything that is left to chance.", min=0)] = 1,
    plant: Annotated[
        Path | None, typer.Option(help="A plant file, or the name of a shipped plant; else the default one.")
    ] = None,
    traffic: Traffic = None,
) -> None:
    """Kill and restart agents, vehicles and brokers in any order, behind a proxy that drops, doubles, delays, corrupts and reorders messages.

    Vehicles speak VDA 5050 2.0, 2.1 and 3.0 by turns. Criteria: every task is delivered once or withdrawn, no action is carried out twice,
    no invariant is broken. Exit 1 otherwise.
    """
    from dray.cli.runtime.options import right_of_way
    from dray.cli.runtime.output import table
    from dray.plant import default_plant, load_plant
    from dray_sim.vda5050.kills import play

    on = right_of_way(traffic)
    outcome = play(default_plant() if plant is None else load_plant(plant), seed, kills, traffic=on)
    rows = [
        *((f"killed: {what}", str(count)) for what, count in sorted(outcome.kills.items())),
        *((f"messages: {what}", str(count)) for what, count in sorted(outcome.messages.items())),
        ("tasks opened", str(len(outcome.opened))),
        *((f"tasks {what}", str(count)) for what, count in sorted(outcome.outcomes.items())),
        ("actions carried out", str(outcome.actions)),
        ("actions carried out twice", str(len(outcome.twice))),
    ]
    table(("what", "count"), rows)
    given = "" if plant is None else f" --plant {plant}"
    typer.echo(
        f"replay: dray sim vehicles --kills {kills} --seed {seed}{given} {'--traffic' if on else '--no-traffic'}"
    )
    for failure in outcome.failures:
        typer.echo(f"dray: {failure}", err=True)
    if outcome.failures:
        raise typer.Exit(1)
