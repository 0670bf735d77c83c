"""What a draft of a plant is worth: its faults and warnings, and the plant file that it would be.

A draft is a plant file of any shape, with two sections of its own: `closed`, lanes that are not driven in it, and `plan`, where a
floor plan lies under it. Neither is part of the plant file.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

import msgspec

from dray.errors import PlantError
from dray.gateway.factory.floor_repairs import FloorRepairs
from dray.gateway.factory.repairs import Repairs, RepairView
from dray.plant import Plant, PlantFile, parse_plant
from dray.plant.exchange.onto import put_onto
from dray.plant.exchange.read import read_layout
from dray.plant.file.document import read_document, write_document
from dray.plant.file.file import document_faults
from dray.plant.file.reasons import Reason, told
from dray.plant.file.text_encoding import UnknownEncodingError, decode_text
from dray.plant.planning.advice import advice

OWN = frozenset({"closed", "plan"})
"""Sections of a draft that no plant file has."""

MAX_FINDINGS = 200
"""That are told; whoever has more solves these first."""

MAX_DEPTH = 12
"""Of lists and mappings in a draft; a plant needs six."""

INDEX = re.compile(r"\[(\d+)\]")

PATH = re.compile(r"\w+\[\d+\](?:\.lanes\[\d+\])?")
"""How a reason names another entry."""

Data = dict[str, Any]

Ends = tuple[str | None, str | None]
"""From where to where a lane leads; None where it does not say."""

Kept = dict[str, list[int]]
"""Of each list of which entries are left out, as the plant file calls it, the indices of the others in the draft."""


class FindingView(msgspec.Struct, frozen=True, kw_only=True):
    """One thing to be seen to in a draft."""

    level: str
    """error, open (to be filled in) or warning."""
    field: str
    """Where in the draft, as `machines[3].node`; of a warning, and of vehicles without room, the section."""
    text: str
    """What is wrong, with figures, and what to do."""
    code: str = ""
    """Of the text, so that panels tell it in the reader's language."""
    values: dict[str, Any] = {}
    """What is filled into it: texts, numbers, other reasons (`code`, `values`, `text`), and lists of these."""
    repair: RepairView | None = None
    """A change that solves it, tried before it is offered; null where none is known."""


class NoteView(msgspec.Struct, frozen=True, kw_only=True):
    """Something that was odd in the file of which a draft or its floor plan was made."""

    text: str
    """What, where and how often, in one line."""
    place: str = ""
    """The first place: a JSON pointer, or the line and element of an XML file."""
    count: int = 1
    """How often the same was found."""
    code: str = ""
    """Of what was found, so that panels tell it in the reader's language."""
    values: dict[str, Any] = {}
    """What is filled into it, as in a finding."""


def findings(data: Data) -> list[FindingView]:
    """The faults of a draft; of one without faults what will starve in it. The rules are those of `dray plant check`."""
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
    """The plant file that a draft would be, and which entries of the draft are in it."""
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
    """Doors without the lanes that are not driven; one that stands on no other is not there.

    Args:
        doors: of the draft.
        driven: its lanes, and whether each is driven. A door may name one that is driven both ways by either end.
        kept: where it is noted which are left.
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
    """What a lane says of its ends; they may be anything."""
    start, end = (lane.get("start"), lane.get("end")) if isinstance(lane, dict) else (None, None)
    return (start if isinstance(start, str) else None, end if isinstance(end, str) else None)


def as_yaml(data: str) -> str:
    """The text of that file, of a draft in JSON."""
    return write_document(as_file(msgspec.json.decode(data))[0])


def read_file(
    content: str | bytes, name: str, onto: Plant | None, unit: str = ""
) -> tuple[Data, list[NoteView]]:
    """A plant file, a LIF file or a model of openTCS as the content of a draft; and what was odd in it.

    Args:
        content: the file; its text where somebody else has read it.
        name: of the file, for errors.
        unit: of a LIF file, `m`, `cm` or `mm`; found out if it is empty.
        onto: where what a layout cannot tell is taken from; None to leave it open.

    Raises:
        PlantError: it is none of them.
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
    try:
        return msgspec.to_builtins(parse_plant(text, name).file), []
    except PlantError as error:
        unfinished = _unfinished(text, name)
        if unfinished is None:
            raise
        return unfinished, [] if error.field else [NoteView(text=str(error))]


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
    """The text of a file, as far as its beginning tells what it is; a layout says itself how it is to be read."""
    if content.lstrip(b" \t\r\n").startswith(b"<") and b"\0" not in content[:4]:
        return "<"
    try:
        return decode_text(content).text
    except UnknownEncodingError:
        raise PlantError(name, "", "is not UTF-8: save it as UTF-8") from None


def _unfinished(text: str, name: str) -> Data | None:
    data = read_document(text, name).data
    return data if isinstance(data, dict) else None


def _closed(data: Data) -> Iterator[tuple[str, str]]:
    closed = data.get("closed")
    for one in closed if isinstance(closed, list) else ():
        if isinstance(one, dict):
            yield str(one.get("start")), str(one.get("end"))


def _repair_in_draft(repair: RepairView | None, kept: Kept) -> RepairView | None:
    """A repair of the plant file as it is one of the draft."""
    if repair is None or repair.index is None or repair.section not in kept:
        return repair
    return msgspec.structs.replace(repair, index=kept[repair.section][repair.index])


def _in_draft(field: str, kept: Kept) -> str:
    """A field of the plant file as it is called in the draft."""

    def index(found: re.Match[str]) -> str:
        entries, at = kept.get(field[: found.start()]), int(found[1])
        # What people call things may look like a field.
        return found[0] if entries is None or at >= len(entries) else f"[{entries[at]}]"

    return INDEX.sub(index, field)
