"""What `dray plant check` calls errors, said on stderr when a plant is started all the same."""

from __future__ import annotations

import typer

from dray.plant import Plant
from dray.plant.planning.advice import advice
from dray.plant.planning.room import ERRORS

HEAD = "dray: {plant} is started, although `dray plant check` says that it cannot work as it is:"


def tell_errors(plant: Plant, *, traffic: bool, load_frac: float | None = None) -> None:
    """Name every error of a plant that is about to run; nothing for a plant without one.

    Args:
        plant: without faults.
        traffic: whether vehicles drive with right of way; places without room for two vehicles are no error else.
        load_frac: part of the machines' time that its orders will take; None if unknown.
    """
    errors = [
        each
        for each in advice(plant, load_frac)
        if each.level == "error" and (traffic or each.kind not in ERRORS)
    ]
    if errors:
        typer.echo(HEAD.format(plant=plant.id), err=True)
    for each in errors:
        typer.echo(f"  {each.field}: error: {each.kind}: {each.text}", err=True)
