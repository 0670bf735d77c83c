"""Slow work on drafts: reading large bodies, judging them, writing plant files. Side work (`http.side_work`).

Bodies, drafts and answers are passed as JSON, which costs the event loop nothing.
"""

from __future__ import annotations

import base64
from typing import TYPE_CHECKING

import msgspec

from dray.errors import PlantError
from dray.gateway.factory.plant_drafts import MAX_DEPTH, NoteView, as_yaml, deeper_than, findings, read_file
from dray.gateway.http.problems import FieldError, unusable
from dray.gateway.http.unread import read
from dray.gateway.routes.factory.plant_draft_bodies import ChangedDraft, DraftView, FloorPlan, NewDraft
from dray.plant import Plant
from dray.plant.model import PlantFile

if TYPE_CHECKING:
    from dray.store.factory.plant_drafts import DraftRow

MAX_TOLD = 10
"""Maximum faults named when a draft cannot be played: more usually have one cause."""


class ReadDraft(msgspec.Struct, frozen=True, kw_only=True):
    """The content to store."""

    name: str
    data: str = ""
    notes: str = ""
    file_name: str = ""
    fault: FieldError | None = None
    """Reason if it cannot be stored."""


def new_draft(body: bytes, running: bytes) -> ReadDraft:
    """The content of a new draft.

    Args:
        body: a `NewDraft`.
        running: the running plant's file.
    """
    request = read(NewDraft, body)
    name, file_name, notes = request.name, request.file_name, list[NoteView]()
    data = running.decode()
    file = _file(request)
    if isinstance(file, FieldError):
        return ReadDraft(name=name, file_name=file_name, fault=file)
    if file is not None:
        onto = Plant(msgspec.json.decode(running, type=PlantFile)) if request.onto_running else None
        try:
            content, notes = read_file(file, file_name, onto, request.unit)
        except PlantError as error:
            return ReadDraft(name=name, file_name=file_name, fault=FieldError("file", str(error.reason)))
        data = _encoded(content)
    return ReadDraft(name=name, file_name=file_name, data=data, notes=_encoded(notes))


def changed_draft(body: bytes) -> ReadDraft:
    """The new content of a draft, from a `ChangedDraft`."""
    request = read(ChangedDraft, body)
    if deeper_than(request.data, MAX_DEPTH):
        fault = FieldError("data", f"is nested more than {MAX_DEPTH} levels deep")
        return ReadDraft(name=request.name, fault=fault)
    try:
        data = _encoded(request.data)
    except UnicodeEncodeError:
        fault = FieldError("data", "half of a character stands in it: write it anew")
        return ReadDraft(name=request.name, fault=fault)
    return ReadDraft(name=request.name, data=data)


def floor_plan(body: bytes) -> FloorPlan:
    """A picture to lay under a draft."""
    return read(FloorPlan, body)


class KeptDraft(msgspec.Struct, frozen=True, kw_only=True):
    """The content of a draft's row. The row itself would load SQL's packages, which takes a side process a second."""

    id: str
    name: str
    version: int
    by: str
    at_s: float
    data: str
    notes: str
    plan_type: str

    @classmethod
    def of(cls, row: DraftRow) -> KeptDraft:
        """The content of a row."""
        return msgspec.convert(row, cls, from_attributes=True)


def draft_view(row: KeptDraft) -> bytes:
    """A draft as JSON for the answer."""
    data = msgspec.json.decode(row.data)
    view = DraftView(
        id=row.id,
        name=row.name,
        version=row.version,
        by=row.by,
        at_s=row.at_s,
        data=data,
        findings=tuple(findings(data)),
        notes=tuple(
            NoteView(text=each) if isinstance(each, str) else msgspec.convert(each, NoteView)
            # Older drafts have plain lines of text.
            for each in msgspec.json.decode(row.notes)
        ),
        plan_type=row.plan_type,
    )
    return msgspec.json.encode(view)


def plant_file(data: str) -> bytes:
    """The plant file of a draft as the answer has it."""
    return as_yaml(data).encode()


def playable(data: str) -> str:
    """The plant file of a draft without faults.

    Raises:
        Problem: it has faults.
    """
    faults = [each for each in findings(msgspec.json.decode(data)) if each.level != "warning"]
    if faults:
        told = faults[:MAX_TOLD]
        raise unusable(
            *(FieldError(f"data.{each.field}" if each.field else "data", each.text) for each in told)
        )
    return as_yaml(data)


def _file(request: NewDraft) -> str | bytes | FieldError | None:
    """The file of a request, None without one, or why it is invalid."""
    if request.file_base64 is None:
        return request.file
    if request.file is not None:
        return FieldError("file_base64", "file is there, too: give one of the two")
    try:
        return base64.b64decode(request.file_base64, validate=True)
    except ValueError:
        return FieldError.of("file_base64", "no_base64")


def _encoded(value: object) -> str:
    return msgspec.json.encode(value).decode()
