"""The evaluation of a plant draft: faults, warnings, and the resulting plant file.

A draft is a plant file of any shape with two extra sections: `closed`, lanes that are not used, and `plan`,
the position of a floor plan under it. Neither is part of the plant file.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

import msgspec

from dray.errors import PlantError
from dray.gateway.factory.floor_repairs import FloorRepairs
from dray.gateway.factory.repairs import Repairs, RepairView
from dray.plant import Plant, PlantFile
from dray.plant.exchange.onto import put_onto
from dray.plant.exchange.read import read_layout
from dray.plant.file.document import read_document, write_document
from dray.plant.file.file import document_faults, plant_of
from dray.plant.file.reasons import Reason, told
from dray.plant.file.text_encoding import UnknownEncodingError, decode_text
from dray.plant.planning.advice import advice

OWN = frozenset({"closed", "plan"})
"""Sections that only a draft has."""

MAX_FINDINGS = 200
"""Maximum findings reported; solving these reveals more."""

MAX_DEPTH = 12
"""Maximum depth of lists and mappings in a draft; a plant needs six."""

INDEX = re.compile(r"\[(\d+)\]")

PATH = re.compile(r"\w+\[\d+\](?:\.lanes\[\d+\])?")
"""Form in which a reason names another entry."""

Data = dict[str, Any]

Ends = tuple[str | None, str | None]
"""Ends of a lane; None if missing."""

Kept = dict[str, list[int]]
"""Per list with omitted entries, by its plant file name: the draft indices of the entries kept."""


class FindingView(msgspec.Struct, frozen=True, kw_only=True):
    """One finding in a draft."""

    level: str
    """error, open (to be filled in) or warning."""
    field: str
    """Position in the draft, as `machines[3].node`; for a warning or vehicles without room, the section."""
    text: str
    """What is wrong, with figures, and what to do."""
    code: str = ""
    """Code of the text, for translation in panels."""
    values: dict[str, Any] = {}
    """Values for the text: texts, numbers, other reasons (`code`, `values`, `text`), and lists of these."""
    repair: RepairView | None = None
    """A tested change that solves it; null if none is known."""


class NoteView(msgspec.Struct, frozen=True, kw_only=True):
    """An oddity in the file from which a draft or its floor plan was made."""

    text: str
    """What, where and how often, in one line."""
    place: str = ""
    """The first place: a JSON pointer, or the line and element of an XML file."""
    count: int = 1
    """Number of occurrences."""
    code: str = ""
    """Code of the text, for translation in panels."""
    values: dict[str, Any] = {}
    """Values for the text, as in a finding."""


def findings(data: Data) -> list[FindingView]:
    """The faults of a draft; without faults, its warnings. The rules are those of `dray plant check`."""
    found = []
    file, kept = as_file(data)
    repairs: Repairs | None = None
    for field, reason in document_faults(file):
        code = reason.code if isinstance(reason, Reason) else ""
        level = "open" if code in ("unassigned", "open") else "error"
        repair = None
        if level == "error":
            repairs = repairs or Repairs(file)
            repair = _repair_in_draft(repairs.of(field, reason), kept)

        def named(text: str) -> str:
            return PATH.sub(lambda found: _in_draft(found[0], kept), text)

        found.append(
            FindingView(
                level=level,
                field=_in_draft(field, kept),
                text=named(str(reason)),
                code=code,
                values=told(reason, named),
                repair=repair,
            )
        )
        if len(found) == MAX_FINDINGS:
            return found
    if not found:
        plant = Plant(msgspec.convert(file, PlantFile))
        floor = FloorRepairs(plant)
        found = [
            FindingView(
                level=each.level,
                field=each.field,
                text=str(each.text),
                code=each.text.code,
                values=told(each.text, str),
                repair=floor.of(each),
            )
            for each in advice(plant)[:MAX_FINDINGS]
        ]
    return found


def as_file(data: Data) -> tuple[Data, Kept]:
    """The plant file of a draft, and which entries of the draft are in it."""
    file = {name: value for name, value in data.items() if name not in OWN}
    lanes, closed = file.get("lanes"), set(_closed(data))
    kept: Kept = {}
    if not isinstance(lanes, list) or not closed:
        return file, kept
    kept["lanes"] = [index for index, lane in enumerate(lanes) if _ends_of(lane) not in closed]
    file["lanes"] = [lanes[index] for index in kept["lanes"]]
    if isinstance(file.get("doors"), list):
        driven = {ends: ends not in closed for ends in map(_ends_of, lanes)}
        file["doors"] = _doors(file["doors"], driven, kept)
    return file, kept


def _doors(doors: list[Any], driven: Mapping[Ends, bool], kept: Kept) -> list[object]:
    """Doors without unused lanes; a door with no other lane is left out.

    Args:
        doors: the draft's doors.
        driven: per lane, whether it is used. A door may name a two-way lane by either direction.
        kept: takes the indices of what is left.
    """
    left: list[object] = []
    kept["doors"] = []
    for index, door in enumerate(doors):
        lanes = door.get("lanes") if isinstance(door, dict) else None
        if isinstance(lanes, list):
            on = [
                at
                for at, (start, end) in enumerate(map(_ends_of, lanes))
                if driven.get((start, end), driven.get((end, start), True))
            ]
            if lanes and not on:
                continue
            kept[f"doors[{len(left)}].lanes"] = on
            left.append({**door, "lanes": [lanes[at] for at in on]})
        else:
            left.append(door)
        kept["doors"].append(index)
    return left


def _ends_of(lane: object) -> Ends:
    """The ends that a lane names, which may be of any type."""
    start, end = (lane.get("start"), lane.get("end")) if isinstance(lane, dict) else (None, None)
    return (start if isinstance(start, str) else None, end if isinstance(end, str) else None)


def as_yaml(data: str) -> str:
    """The plant file as text, of a draft in JSON."""
    return write_document(as_file(msgspec.json.decode(data))[0])


def read_file(
    content: str | bytes, name: str, onto: Plant | None, unit: str = ""
) -> tuple[Data, list[NoteView]]:
    """Read a plant file, LIF file or openTCS model as a draft, with its oddities.

    Args:
        content: the file, or its text if read already.
        name: name of the file, for errors.
        unit: unit of a LIF file, `m`, `cm` or `mm`; guessed if empty.
        onto: plant that supplies what a layout lacks; None to leave it open.

    Raises:
        PlantError: it is none of these files.
    """
    text = content if isinstance(content, str) else _text(content, name)
    begins = text.lstrip("\ufeff \t\r\n")[:1]
    if begins in ("<", "{"):
        imported = read_layout(content, name, unit=unit)
        data = imported.data if onto is None else put_onto(imported.data, onto)
        return data, [
            NoteView(
                text=note.line(),
                place=note.place,
                count=note.count,
                code=note.text.code,
                values=told(note.text, str),
            )
            for note in imported.notes
        ]
    document = read_document(text, name)
    try:
        return msgspec.to_builtins(plant_of(document, name).file), []
    except PlantError as error:
        if not isinstance(document.data, dict):
            raise
        return document.data, [] if error.field else [NoteView(text=str(error))]


def deeper_than(value: object, depth: int) -> bool:
    """Whether lists and mappings are nested deeper than this."""
    level = [value]
    for _ in range(depth + 1):
        level = [
            inner
            for each in level
            for inner in (each.values() if isinstance(each, dict) else each if isinstance(each, list) else ())
        ]
        if not level:
            return False
    return True


def _text(content: bytes, name: str) -> str:
    """The text of a file, as far as needed to tell its type; a layout names its own encoding."""
    if content.lstrip(b" \t\r\n").startswith(b"<") and b"\0" not in content[:4]:
        return "<"
    try:
        return decode_text(content).text
    except UnknownEncodingError:
        raise PlantError(name, "", "is not UTF-8: save it as UTF-8") from None


def _closed(data: Data) -> Iterator[tuple[str, str]]:
    closed = data.get("closed")
    for one in closed if isinstance(closed, list) else ():
        if isinstance(one, dict):
            yield str(one.get("start")), str(one.get("end"))


def _repair_in_draft(repair: RepairView | None, kept: Kept) -> RepairView | None:
    """A plant file's repair as a repair of the draft."""
    if repair is None or repair.index is None or repair.section not in kept:
        return repair
    return msgspec.structs.replace(repair, index=kept[repair.section][repair.index])


def _in_draft(field: str, kept: Kept) -> str:
    """The draft's name of a plant file's field."""

    def index(found: re.Match[str]) -> str:
        entries, at = kept.get(field[: found.start()]), int(found[1])
        # A name given by people may look like a field.
        return found[0] if entries is None or at >= len(entries) else f"[{entries[at]}]"

    return INDEX.sub(index, field)
