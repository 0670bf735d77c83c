"""What a draft of a plant is worth: its faults and warnings, and the plant file that it would be.

A draft is a plant file of any shape, with two sections of its own: `closed`, lanes that are not driven in it, and `plan`, where a
floor plan lies under it. Neither is part of the plant file.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import msgspec

from dray.errors import PlantError
from dray.plant import Plant, PlantFile, parse_plant
from dray.plant.exchange.onto import put_onto
from dray.plant.exchange.read import read_layout
from dray.plant.file.document import read_document, write_document
from dray.plant.file.file import document_faults
from dray.plant.planning.advice import advice

OWN = frozenset({"closed", "plan"})
"""Sections of a draft that no plant file has."""

MAX_FINDINGS = 200
"""That are told; whoever has more solves these first."""

MAX_DEPTH = 12
"""Of lists and mappings in a draft; a plant needs six."""

LANE = re.compile(r"^lanes\[(\d+)\]")

Data = dict[str, Any]


class FindingView(msgspec.Struct, frozen=True, kw_only=True):
    """One thing to be seen to in a draft."""

    level: str
    """error, open (to be filled in) or warning."""
    field: str
    """Where in the draft, as `machines[3].node`; of a warning the section."""
    text: str
    """What is wrong, with figures, and what to do."""


def findings(data: Data) -> list[FindingView]:
    """The faults of a draft; of one without faults what will starve in it. The rules are those of `dray plant check`."""
    found = []
    file, kept = as_file(data)
    for field, reason in document_faults(file):
        level = "open" if field.startswith("unassigned[") or reason.startswith("is open: ") else "error"
        found.append(FindingView(level=level, field=_in_draft(field, kept), text=reason))
        if len(found) == MAX_FINDINGS:
            return found
    if not found:
        plant = Plant(msgspec.convert(file, PlantFile))
        found = [
            FindingView(level="warning", field=each.field, text=each.text)
            for each in advice(plant)[:MAX_FINDINGS]
        ]
    return found


def as_file(data: Data) -> tuple[Data, list[int]]:
    """The plant file that a draft would be, and which of its lanes are in it, by index."""
    file = {name: value for name, value in data.items() if name not in OWN}
    lanes, closed = file.get("lanes"), set(_closed(data))
    if not isinstance(lanes, list) or not closed:
        return file, list(range(len(lanes))) if isinstance(lanes, list) else []
    kept = [
        index
        for index, lane in enumerate(lanes)
        if not (isinstance(lane, dict) and (lane.get("start"), lane.get("end")) in closed)
    ]
    file["lanes"] = [lanes[index] for index in kept]
    return file, kept


def as_yaml(data: Data) -> str:
    """The text of that file."""
    return write_document(as_file(data)[0])


def read_file(text: str, name: str, onto: Plant | None) -> tuple[Data, list[str]]:
    """A plant file, a LIF file or a model of openTCS as the content of a draft; and what was odd in it.

    Args:
        text: of the file.
        name: of the file, for errors.
        onto: where what a layout cannot tell is taken from; None to leave it open.

    Raises:
        PlantError: it is none of them.
    """
    begins = text.lstrip("\ufeff \t\r\n")[:1]
    if begins in ("<", "{"):
        imported = read_layout(text.encode(), name)
        data = imported.data if onto is None else put_onto(imported.data, onto)
        return data, [note.line() for note in imported.notes]
    try:
        return msgspec.to_builtins(parse_plant(text, name).file), []
    except PlantError as error:
        unfinished = _unfinished(text, name)
        if unfinished is None:
            raise
        return unfinished, [] if error.field else [str(error)]


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


def _unfinished(text: str, name: str) -> Data | None:
    data = read_document(text, name).data
    return data if isinstance(data, dict) else None


def _closed(data: Data) -> Iterator[tuple[str, str]]:
    closed = data.get("closed")
    for one in closed if isinstance(closed, list) else ():
        if isinstance(one, dict):
            yield str(one.get("start")), str(one.get("end"))


def _in_draft(field: str, kept: list[int]) -> str:
    """A field of the plant file as it is called in the draft."""
    found = LANE.match(field)
    if found is None:
        return field
    return f"lanes[{kept[int(found[1])]}]{field[found.end() :]}"
