"""`dray plant`: plant files."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeVar

import typer

from dray.cli.commands.plant_exchange import export_layout, floor_plan, import_layout
from dray.cli.commands.plant_ready import ready
from dray.cli.runtime.options import number

if TYPE_CHECKING:
    from dray.plant import Plant

T = TypeVar("T")

HEAD = """\
# A small plant to go on from, made by `dray plant new`: metres (x to the right, y up), seconds, pieces.
# `dray plant check` says what is wrong with it and what will starve, `dray plant draw` makes a picture.
"""

app = typer.Typer(no_args_is_help=True, help="Plant files.")


app.command("import")(import_layout)
app.command("export")(export_layout)
app.command("picture")(floor_plan)
app.command("ready")(ready)


@app.callback()
def plant() -> None:
    """Plant files."""


@app.command()
def check(
    file: Annotated[Path, typer.Argument(help="A plant file (YAML), or the name of a shipped plant.")],
    strict: Annotated[bool, typer.Option("--strict", help="Exit 2 when there is a warning.")] = False,
    load: Annotated[
        float | None,
        typer.Option(
            parser=number(most=1.0),
            metavar="FRACTION",
            help="Part of the machines' time that orders will take, from 0 to 1: what is full below it is an error.",
        ),
    ] = None,
    json: Annotated[Path | None, typer.Option(help="Write the warnings here too.")] = None,
) -> None:
    """Validate a plant file; every fault is named by line and field, and the exit code is 2.

    In a file without faults, places without room for two vehicles are errors, too, and starving parts are warnings. Each has a
    figure and a remedy.
    """
    import msgspec

    from dray.cli.runtime.output import write_json
    from dray.plant import load_plant, sum_up
    from dray.plant.planning.advice import advice

    chosen = load_plant(file)
    typer.echo(sum_up(chosen))
    warnings = advice(chosen, load)
    for warning in warnings:
        typer.echo(f"{file}: {warning.field}: {warning.level}: {warning.kind}: {warning.text}")
    if json is not None:
        write_json(json, [msgspec.structs.replace(each, text=str(each.text)) for each in warnings])
    if any(strict or warning.level == "error" for warning in warnings):
        raise typer.Exit(2)


@app.command("json")
def as_json(
    file: Annotated[Path | None, typer.Argument(help="A plant file (YAML); else the default plant.")] = None,
    places: Annotated[
        bool,
        typer.Option(
            "--places",
            help="Write its places for right of way instead, and who keeps their reservation tables.",
        ),
    ] = False,
) -> None:
    """Write a plant as JSON, every default filled in: for agents that read no YAML.

    Two-lane roads are written as they are driven: stop points, and one-way lanes between them.
    """
    import msgspec

    from dray.protocol.traffic.places_document import places_document

    plant = chosen_plant(file)
    written = places_document(plant) if places else plant.driven
    typer.echo(msgspec.json.format(msgspec.json.encode(written)))


@app.command()
def draw(
    file: Annotated[Path, typer.Argument(help="A plant file (YAML), or the name of a shipped plant.")],
    out: Annotated[
        Path | None, typer.Option("-o", "--out", help="The SVG file; else standard output.")
    ] = None,
) -> None:
    """Draw a plant file as a picture (SVG), for a browser or a document; an unfinished one as far as possible."""
    from dray.cli.runtime.output import write_text
    from dray.plant.file.file import unfinished_plant
    from dray.plant.planning.drawing import draw as drawn

    chosen, faults = unfinished_plant(file)
    if faults:
        typer.echo(f"{file}: {len(faults)} faults or open points, see dray plant check {file}", err=True)
    picture = drawn(chosen)
    if out is None:
        typer.echo(picture, nl=False)
    else:
        write_text(out, picture, "--out")


@app.command()
def new(
    out: Annotated[Path, typer.Argument(help="The plant file to write.")] = Path("plant.yaml"),
    plant: Annotated[str | None, typer.Option(help="Its id: letters, digits, _ . and -.")] = None,
    name: Annotated[str | None, typer.Option(help="What people call it.")] = None,
    machines: Annotated[int | None, typer.Option(help="Number of machines.", min=1, max=40)] = None,
    vehicles: Annotated[int | None, typer.Option(help="Number of vehicles.", min=1, max=40)] = None,
    products: Annotated[int | None, typer.Option(help="Number of products.", min=1, max=40)] = None,
    cycle: Annotated[
        float | None,
        typer.Option(
            parser=number(least=1.0, most=36_000.0),
            metavar="SECONDS",
            help="Seconds for one piece, from 1 to 36000.",
        ),
    ] = None,
    chargers: Annotated[
        int | None,
        typer.Option(help="Number of chargers; 0 for as many as the vehicles need.", min=0, max=40),
    ] = None,
    yes: Annotated[
        bool,
        typer.Option("--yes", "-y", help="Ask nothing; take the default of each value without an option."),
    ] = False,
    force: Annotated[bool, typer.Option("--force", help="Write over a file that is there.")] = False,
) -> None:
    """Write a small plant that runs, as a start; asks for values without an option."""
    from dray.cli.runtime.output import write_text
    from dray.errors import SettingsError
    from dray.plant import parse_plant, plant_yaml, sum_up
    from dray.plant.planning.advice import advice
    from dray.plant.planning.sketch import Wishes, sketch
    from dray.plant.plant import Plant

    if out.exists() and not force:
        raise SettingsError("OUT", f"{out} is there already: choose another file, or give --force")
    usual = Wishes()
    wishes = Wishes(
        plant=_asked("Id of the plant", plant, usual.plant, yes, _id),
        name=_asked("Its name", name, usual.name, yes, _name),
        machines=_asked("Machines", machines, usual.machines, yes, _count(1)),
        vehicles=_asked("Vehicles", vehicles, usual.vehicles, yes, _count(1)),
        products=_asked("Products", products, usual.products, yes, _count(1)),
        cycle_s=_asked("Seconds for one piece", cycle, usual.cycle_s, yes, _seconds),
        chargers=_asked("Chargers (0: as many as needed)", chargers, usual.chargers, yes, _count(0)),
    )
    text = HEAD + plant_yaml(Plant(sketch(wishes)))
    made = parse_plant(text, str(out))
    write_text(out, text, "OUT")
    typer.echo(sum_up(made))
    for warning in advice(made):
        typer.echo(f"{out}: {warning.field}: {warning.level}: {warning.kind}: {warning.text}")
    typer.echo(
        f"next: dray plant draw {out} -o plant.svg; dray sim run day --plant {out}; dray up --plant {out}"
    )


def _asked(question: str, given: T | None, usual: T, silent: bool, check: Callable[[str], T]) -> T:
    """The option's value, else the person's answer, else the default."""
    if given is not None:
        return check(str(given))
    if silent:
        return usual
    answer: T = typer.prompt(question, default=usual, value_proc=lambda text: check(str(text)), err=True)
    return answer


def _id(text: str) -> str:
    from dray.plant.model import ID_RULE, is_id

    if not is_id(text):
        raise typer.BadParameter(ID_RULE)
    return text


def _name(text: str) -> str:
    if not 1 <= len(text.strip()) <= 80:
        raise typer.BadParameter("write 1 to 80 characters")
    return text.strip()


def _count(least: int) -> Callable[[str], int]:
    def checked(text: str) -> int:
        if not (text.strip().isdecimal() and least <= int(text) <= 40):
            raise typer.BadParameter(f"write a whole number from {least} to 40")
        return int(text)

    return checked


def _seconds(text: str) -> float:
    try:
        seconds = float(text)
    except ValueError:
        seconds = 0.0
    if not 1.0 <= seconds <= 36_000.0:
        raise typer.BadParameter("write seconds, from 1 to 36000")
    return seconds


def chosen_plant(file: Path | None) -> Plant:
    """The plant of a file or of a shipped plant's name; the default plant for None.

    Raises:
        PlantError: the file cannot be used.
    """
    from dray.plant import default_plant, load_plant

    return default_plant() if file is None else load_plant(file)
