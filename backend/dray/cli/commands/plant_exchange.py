"""`dray plant import`, `dray plant export` and `dray plant picture`: layouts and floor plans of other systems."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated

import typer

IMPORTED = """\
# Imported from {source} ({format}) by `dray plant import`: metres (x to the right, y up), seconds, pieces.
# Not finished: `dray plant check` names what is open, each with its field. What stands as null is to be filled in.
"""


PLANT_FILE = re.compile(r"^(plant|nodes|lanes|machines|fleet)\s*:", re.MULTILINE)
"""A line that a plant file has, and neither JSON nor XML."""


def import_layout(
    file: Annotated[Path, typer.Argument(help="A LIF file (JSON), or a plant model of openTCS (XML).")],
    out: Annotated[
        Path | None, typer.Option("-o", "--out", help="The plant file to write; else FILE with .yaml.")
    ] = None,
    mapping: Annotated[
        Path | None,
        typer.Option(help="The mapping to write (JSON): original ids, and what a plant has no field for."),
    ] = None,
    plant: Annotated[str, typer.Option(help="The id of the plant; else from the name of FILE.")] = "",
    name: Annotated[str, typer.Option(help="What people call the plant; else what FILE says.")] = "",
    onto: Annotated[
        Path | None,
        typer.Option(
            help="A plant: what the layout cannot tell is taken from it, as far as its nodes are there."
        ),
    ] = None,
    layout: Annotated[
        list[str] | None,
        typer.Option(help="Id of a layout, where a LIF file has several; may be repeated. Else all."),
    ] = None,
    unit: Annotated[
        str, typer.Option(help="Unit of lengths in a LIF file: m, cm or mm; else it is found out.")
    ] = "",
    force: Annotated[bool, typer.Option("--force", help="Write over files that are there.")] = False,
) -> None:
    """Convert a layout of another system into a plant file, and list what the layout lacks.

    Odd or unusable parts are reported with their places in FILE.
    """
    from dray.cli.runtime.output import write_json, write_text
    from dray.errors import SettingsError
    from dray.plant import load_plant
    from dray.plant.exchange.lif_units import UNITS
    from dray.plant.exchange.onto import put_onto
    from dray.plant.exchange.read import MAX_BYTES, read_layout
    from dray.plant.file.document import write_document
    from dray.plant.file.file import document_faults
    from dray.plant.model import ID_RULE, is_id

    if unit and unit not in UNITS:
        raise SettingsError("--unit", f"{unit} is none of {', '.join(UNITS)}")
    if plant and not is_id(plant):
        raise SettingsError("--plant", ID_RULE)
    plant_file = out or file.with_suffix(".yaml")
    mapping_file = mapping or plant_file.with_suffix(".mapping.json")
    try:
        with file.open("rb") as stream:
            content = stream.read(MAX_BYTES + 1)
    except OSError as error:
        raise SettingsError("FILE", f"{file} cannot be read: {error.strerror}") from None
    if not content.lstrip().startswith((b"<", b"{")) and PLANT_FILE.search(content.decode("latin-1")):
        raise SettingsError(
            "FILE",
            f"{file} is a plant file already: `dray plant check {file}` says what is wrong with it, "
            f"`dray up --plant {file}` runs it; what is imported is a layout of another system, LIF (JSON) or openTCS (XML)",
        )
    for option, path in (("--out", plant_file), ("--mapping", mapping_file)):
        if path.exists() and not force:
            raise SettingsError(option, f"{path} is there already: choose another file, or give --force")
    imported = read_layout(content, str(file), plant=plant, name=name, unit=unit, layouts=tuple(layout or ()))
    data = imported.data
    if onto is not None:
        data = put_onto(data, load_plant(onto))
    head = IMPORTED.format(source=file.name, format=imported.mapping["format"])
    write_text(plant_file, head + write_document(data), "--out")
    write_json(mapping_file, imported.mapping)
    for note in imported.notes:
        typer.echo(f"{file}: {note.line()}")
    lanes = sum(2 if lane.get("both_ways") else 1 for lane in data["lanes"])
    typer.echo(
        f"{plant_file}: {len(data['nodes'])} nodes, {lanes} directed lanes, "
        f"{len(data['unassigned'])} stations to be assigned; original ids in {mapping_file}"
    )
    points = list(document_faults(data))
    if points:
        typer.echo(f"open points ({len(points)}), as dray plant check {plant_file} says them:")
    for field, reason in points:
        typer.echo(f"  {field}: {reason}")


def export_layout(
    file: Annotated[Path, typer.Argument(help="A plant file (YAML), or the name of a shipped plant.")],
    lif: Annotated[
        bool, typer.Option("--lif", help="Write LIF of VDMA. It is the only format, and must be given.")
    ] = False,
    lif_version: Annotated[str, typer.Option(help="Version of LIF: 1.0.0 or 2.0.0.")] = "1.0.0",
    out: Annotated[Path | None, typer.Option("-o", "--out", help="The file; else standard output.")] = None,
) -> None:
    """Write a plant for other systems: its lanes as they are driven, and its stations."""
    from datetime import UTC, datetime

    from dray.cli.runtime.output import write_text
    from dray.errors import SettingsError
    from dray.plant import load_plant
    from dray.plant.exchange.lif_export import VERSIONS, export_lif

    if not lif:
        raise SettingsError("--lif", "say in which format: --lif is the one that there is")
    if lif_version not in VERSIONS:
        raise SettingsError("--lif-version", f"{lif_version} is none of {', '.join(VERSIONS)}")
    plant = load_plant(file)
    text = export_lif(plant, datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ"), lif_version)
    if plant.doors:
        typer.echo(f"left out: {', '.join(plant.doors)}: LIF knows no doors", err=True)
    if out is None:
        typer.echo(text, nl=False)
    else:
        write_text(out, text, "--out")


def floor_plan(
    file: Annotated[Path, typer.Argument(help="A floor plan in DXF, text or binary.")],
    out: Annotated[
        Path | None, typer.Option("-o", "--out", help="The picture to write (SVG); else FILE with .svg.")
    ] = None,
    json: Annotated[Path | None, typer.Option(help="Write its size and what was left out here.")] = None,
) -> None:
    """Convert a floor plan into a picture for the plant editor's drafts. Needs the extra `dxf`."""
    from dray.cli.runtime.output import write_json, write_text
    from dray.errors import SettingsError
    from dray.plant.exchange.dxf import read_dxf
    from dray.plant.file.reasons import told

    try:
        plan = read_dxf(file)
    except OSError as error:
        raise SettingsError("FILE", f"{file} cannot be read: {error.strerror}") from None
    write_text(out or file.with_suffix(".svg"), plan.svg, "--out")
    if json is not None:
        notes = [{"text": str(note), "code": note.code, "values": told(note, str)} for note in plan.notes]
        write_json(json, {"width_m": plan.width_m, "height_m": plan.height_m, "notes": notes})
    for note in plan.notes:
        typer.echo(f"{file}: {note}")
    typer.echo(f"{out or file.with_suffix('.svg')}: {plan.width_m:g} m x {plan.height_m:g} m")
