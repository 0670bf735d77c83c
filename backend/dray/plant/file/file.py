"""Reading a plant file: text to shapes to a checked `Plant`, or every fault by line and field.

There are three passes, each only when the one before it found nothing. They check the YAML (`document`), the shape of
every entry (`model`), and the relations between entries (`check`). In an unfinished file (`unfinished`) open values
are named, and contradictions among the lanes that are drawn.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence, Sized
from functools import cache
from importlib.resources import files
from itertools import islice
from pathlib import Path

import msgspec
from msgspec.structs import replace

from dray.errors import PlantError, PlantErrors
from dray.plant.file.check import Fault, faults, item_faults
from dray.plant.file.check_doors import door_faults
from dray.plant.file.check_floor import floor_faults
from dray.plant.file.check_levels import levels_of
from dray.plant.file.check_power import power_faults
from dray.plant.file.document import Document, read_document, write_document
from dray.plant.file.reasons import Reason
from dray.plant.file.unfinished import drawable, entry_type, has_null, open_points, struct_fields
from dray.plant.model import MachineSpec, Making, PlantFile, Product
from dray.plant.plant import Plant

Defined = tuple[Product, Mapping[str, float]]
"""A product, and seconds for one piece by machine that can make it."""

MAX_BYTES = 8 * 1024 * 1024
"""A plant of 200 machines and 500 vehicles takes 0.3 MiB; more than this is some other file."""

MAX_FAULTS = 100
"""Most faults that are spelt out; an author with more corrects these first."""

MISFITS = (
    (re.compile("^Object missing required field `(?P<name>.*)`$"), "missing"),
    (re.compile("^Object contains unknown field `(?P<name>.*)`$"), "unknown_field"),
    (re.compile("^Expected `array` of length >= 1$"), "is_empty"),
    (re.compile("^Expected `str` matching regex .*202e.*$"), "unseen"),
    (re.compile("^Expected `str` matching regex (?P<regex>.*)$"), "pattern"),
    (re.compile("^Expected `(?P<wanted>.*)`, got `(?P<got>.*)`$"), "other_kind"),
    (re.compile("^Expected `(?P<wanted>.*)` (?P<bound>.*)$"), "bounds"),
    (re.compile("^Invalid enum value (?P<value>.*)$"), "none_of_these"),
)
"""Messages of msgspec for a value of another kind, with our codes."""

DEFAULT_PLANT = "default.yaml"
"""The factory of the paper's Figure 1, part of the package."""

SHIPPED = {
    "default": DEFAULT_PLANT,
    "workshop": "examples/workshop.yaml",
    "two-halls": "examples/two-halls.yaml",
    "large": "examples/large.yaml",
    "single-track": "examples/single-track.yaml",
    "levels": "examples/levels.yaml",
    "laboratory": "examples/laboratory.yaml",
}
"""Plants that are part of the package, by the name under which they are asked for instead of a path."""


def load_plant(path: str | Path) -> Plant:
    """Read and check a plant file.

    Args:
        path: a YAML file in UTF-8, or the name of a shipped plant; a file of that name comes first.

    Raises:
        PlantError: it cannot be read, or has one fault.
        PlantErrors: it has several faults; all are named, in file order.
    """
    if is_shipped(path):
        return shipped_plant(str(path))
    return parse_plant(_text(path), str(path))


def _text(path: str | Path) -> str:
    """The text of a file.

    Raises:
        PlantError: it cannot be read, is too large or is no text.
    """
    name = str(path)
    try:
        with Path(path).open("rb") as stream:
            content = stream.read(MAX_BYTES + 1)
    except FileNotFoundError:
        names = ", ".join(SHIPPED)
        raise PlantError(name, "", f"there is no such file: check the path, or name one of {names}") from None
    except IsADirectoryError:
        raise PlantError(name, "", "is a directory: name a file in it") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise PlantError(name, "", f"cannot be read: {reason}") from None
    if len(content) > MAX_BYTES:
        limit_mib = MAX_BYTES // 1024 // 1024
        raise PlantError(name, "", f"has more than {limit_mib} MiB: this is no plant file")
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise PlantError(name, "", "is not UTF-8: save it as UTF-8", line) from None


def parse_plant(text: str, name: str) -> Plant:
    """Check the text of a plant file.

    Args:
        text: YAML.
        name: of the text in errors, usually its path.

    Raises:
        PlantError: it has one fault.
        PlantErrors: it has several faults; all are named, in file order.
    """
    return plant_of(read_document(text, name), name)


def plant_of(document: Document, name: str) -> Plant:
    """Check a plant file that was read; raises as `parse_plant` does."""
    if document.data is None:
        raise PlantError(name, "", "is empty: a plant begins with `plant: ID` and `name: NAME`")
    if not isinstance(document.data, dict):
        raise PlantError(name, "", "is no mapping: a plant begins with `plant: ID` and `name: NAME`", 1)
    found = _first(document, name, document_faults(document.data))
    if not found:
        return Plant(msgspec.convert(document.data, PlantFile))
    raise found[0] if len(found) == 1 else PlantErrors(tuple(found))


def document_faults(data: dict[str, object]) -> Iterator[tuple[str, str]]:
    """Everything that keeps a plant from being run, as (field, reason); nothing for a good one.

    Args:
        data: the mapping of a plant file, of any shape inside.
    """
    # One by one: of a file of any shape, somebody reads a few of a hundred thousand faults.
    named = set[str]()
    for fault in open_points(data):
        named.add(fault[0])
        yield fault
    has_shape = True
    for fault in _shape_faults(data):
        has_shape = False
        yield fault
    if not has_shape:
        return
    if not named:
        misfit = _misfit("", data, PlantFile)
        if misfit is None:
            file = msgspec.convert(data, PlantFile)
            misfits = list(faults(file))
            yield from misfits or power_faults(Plant(file))
            return
        # A null where nothing of the file could be open.
        named.add(misfit[0].lstrip("."))
        yield misfit[0].lstrip("."), misfit[1]
    # An entry that depends on a faulty one is not reported a second time, nor are placeholders for open values.
    rest = drawable(data)[1]
    if rest is not None:
        yield from (fault for fault in (*floor_faults(rest), *door_faults(rest)) if fault[0] not in named)


def unfinished_plant(path: str | Path) -> tuple[Plant, tuple[PlantError, ...]]:
    """The drawable part of a plant file, and the faults that keep it from being run.

    Raises:
        PlantError: it cannot be read at all.
    """
    try:
        return load_plant(path), ()
    except PlantErrors as errors:
        found: tuple[PlantError, ...] = errors.errors
    except PlantError as error:
        found = (error,)
    if is_shipped(path):
        raise found[0]
    document = read_document(_text(path), str(path))
    if not isinstance(document.data, dict):
        raise found[0]
    return drawable(document.data)[0], found


def with_machine(plant: Plant, spec: MachineSpec, name: str) -> Plant:
    """The same plant with one machine more.

    Args:
        plant: as it was.
        spec: the joining agent.
        name: of the joining agent in errors, usually the path of its file.

    Raises:
        PlantError: it does not fit into this plant.
    """
    file = replace(plant.file, machines=(*plant.file.machines, spec))
    for field, reason in faults(file):
        raise PlantError(name, field, reason)
    return Plant(file)


def products_faults(file: PlantFile, products: Sequence[Defined]) -> list[Fault]:
    """What does not fit together in a plant with these products; nothing for good ones. The last one is `products[0]` here, the one before it `products[1]`.

    Args:
        file: of the plant, without them or with other definitions of them.
        products: as they are to be. Machines that say their time in the plant file need not be named.
    """
    return list(item_faults(file_with_products(file, products)))


def file_with_products(file: PlantFile, products: Sequence[Defined]) -> PlantFile:
    """The file of the same plant with these products, defined one after the other."""
    before = {each.id: each for each in file.products}
    new: dict[str, Product] = {}
    cycles_s: dict[str, dict[str, float]] = {}
    for product, by_machine in products:
        known = new.pop(product.id, None) or before.get(product.id, product)
        # The buffers of those who use it stand in the plant file alone.
        new[product.id] = product if product.buffer else replace(product, buffer=known.buffer)
        for machine, cycle_s in by_machine.items():
            said_s = cycles_s.setdefault(machine, {})
            # What is said last comes last.
            said_s.pop(product.id, None)
            said_s[product.id] = cycle_s
    others = (each for each in file.products if each.id not in new)
    machines = (_making(each, cycles_s[each.id]) if each.id in cycles_s else each for each in file.machines)
    return replace(file, products=(*reversed(new.values()), *others), machines=tuple(machines))


def file_without_products(file: PlantFile, products: Collection[str]) -> PlantFile:
    """The file of the same plant without these products, whose machines make them no more."""
    if not products:
        return file
    gone = frozenset(products)
    return replace(
        file,
        products=tuple(each for each in file.products if each.id not in gone),
        machines=tuple(_not_making(each, gone) for each in file.machines),
    )


def _not_making(machine: MachineSpec, products: frozenset[str]) -> MachineSpec:
    made = tuple(making for making in machine.makes if making.product not in products)
    return machine if len(made) == len(machine.makes) else replace(machine, makes=made)


def _making(machine: MachineSpec, cycles_s: Mapping[str, float]) -> MachineSpec:
    """The same machine with other cycles, in seconds by product."""
    known = {making.product: making for making in machine.makes if making.product in cycles_s}
    others = (making for making in machine.makes if making.product not in cycles_s)
    made = (
        replace(known[product], cycle_s=cycle_s) if product in known else Making(product, cycle_s)
        for product, cycle_s in cycles_s.items()
    )
    return replace(machine, makes=(*others, *made))


def plant_yaml(plant: Plant) -> str:
    """A plant as the text of a plant file; `parse_plant` makes the same plant of it."""
    return write_document(msgspec.to_builtins(plant.file))


def default_plant() -> Plant:
    """The factory of the paper's Figure 1: 12 machines, 8 vehicles."""
    return shipped_plant("default")


def is_shipped(path: str | Path) -> bool:
    """Whether this names a plant of the package, and no file."""
    return str(path) in SHIPPED and not Path(path).is_file()


@cache
def shipped_plant(name: str) -> Plant:
    """A plant of the package by its name; raises `KeyError` for another name."""
    text = files("dray.plant").joinpath(SHIPPED[name]).read_text(encoding="utf-8")
    return parse_plant(text, SHIPPED[name])


def sum_up(plant: Plant) -> str:
    """The contents of a plant, in one line."""
    road_m = sum(lane.length_m for lane in plant.lanes)
    return (
        f"{plant.id} ({plant.name}): {_count(plant.machines, 'machine')} in {_count(plant.stations, 'station')}, "
        f"{_count(plant.fleet, 'vehicle')} of {_count(plant.vehicle_types, 'type')}, {_count(plant.products, 'product')} "
        f"{_levels_told(plant)}of {_count(plant.file.materials, 'material')}, {_count(plant.storages, 'storage')}, "
        f"{_count(plant.chargers, 'charger')}, {_count(plant.parkings, 'parking place')}, {_doors_told(plant)}"
        f"{_count(plant.nodes, 'node')}, {_count(plant.lanes, 'lane')} of {road_m:.0f} m on {plant.width_m:g} m x "
        f"{plant.height_m:g} m"
    )


def _count(things: Sized, name: str) -> str:
    return f"{len(things)} {name}{'s' * (len(things) != 1)}"


def _levels_told(plant: Plant) -> str:
    if not plant.parts:
        return ""
    return f"({len(plant.parts)} of them parts, on {levels_of(plant.file)} levels) "


def _doors_told(plant: Plant) -> str:
    return f"{_count(plant.doors, 'door')}, " if plant.doors else ""


def _first(document: Document, name: str, found: Iterable[tuple[str, str]]) -> list[PlantError]:
    """The first faults, those of the document itself included, in file order."""
    errors = list(document.faults[:MAX_FAULTS])
    rest = iter(found)
    for field, reason in islice(rest, MAX_FAULTS - len(errors)):
        errors.append(PlantError(name, field, reason, document.line_of(field)))
    errors.sort(key=lambda error: error.line or 0)
    if next(rest, None) is not None:
        errors.append(PlantError(name, "", "and more faults: correct these first"))
    return errors


def _shape_faults(data: dict[str, object]) -> Iterator[tuple[str, str]]:
    """The first fault of every entry, as (field, reason); none when the whole has the right shape.

    Open values are no faults here.

    Entries are tried one by one because msgspec stops at the first fault that it meets.
    """
    sections = {section.name: section for section in struct_fields(PlantFile)}
    for name, section in sections.items():
        if name in data:
            if data[name] is None:
                continue
            yield from _section_faults(name, data[name], section.type)
        elif section.required:
            yield "", Reason("missing", name=name)
    for name in data:
        if name not in sections:
            yield name, Reason("no_such_section")


def _section_faults(name: str, value: object, kind: object) -> Iterator[tuple[str, str]]:
    fault = _misfit(name, value, kind)
    if fault is None:
        return
    entry = entry_type(kind)
    if entry is None or not isinstance(value, list) or fault[0] == name:
        yield fault
        return
    for index, item in enumerate(value):
        where = f"{name}[{index}]"
        if isinstance(item, dict) and has_null(item):
            yield from _rest_faults(where, item, entry)
            continue
        fault = _misfit(where, item, entry)
        if fault is not None:
            yield fault


def _rest_faults(
    where: str, entry: dict[str, object], kind: type[msgspec.Struct]
) -> Iterator[tuple[str, str]]:
    """Faults of an entry beside its open values."""
    types = {field.name: field.type for field in struct_fields(kind)}
    for name, value in entry.items():
        if name not in types:
            yield f"{where}.{name}", Reason("no_such_field")
        elif not has_null(value):
            fault = _misfit(f"{where}.{name}", value, types[name])
            if fault is not None:
                yield fault
    for field in struct_fields(kind):
        if field.required and field.name not in entry:
            yield where, Reason("missing", name=field.name)


def _misfit(field: str, value: object, kind: object) -> tuple[str, str] | None:
    """Why a value is not of a kind, as msgspec's ``reason - at `$.path` `` split into field and reason."""
    try:
        msgspec.convert(value, kind)
    except msgspec.ValidationError as error:
        words, _, path = str(error).partition(" - at `$")
        return field + path.rstrip("`"), _reason(words)
    return None


def _reason(words: str) -> Reason:
    """The message of msgspec, with our code."""
    for form, code in MISFITS:
        if found := form.match(words):
            return Reason(code, **found.groupdict())
    return Reason("misfit", words=words[:1].lower() + words[1:])
