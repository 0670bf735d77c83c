"""Requests and answers about drafts of plants."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import msgspec
from pydantic import BaseModel, ConfigDict, Field

from dray.gateway.factory.plant_drafts import FindingView, NoteView
from dray.gateway.factory.shift_player import PlayView, ShiftFigures
from dray.gateway.http.request_bodies import NOTE, Line

LONGEST_H = 8.0
"""Maximum hours of a shift to play."""

EXAMPLE_FIGURES = ShiftFigures(
    orders_placed=61,
    orders_delivered=60,
    on_time_frac=0.984,
    starvation_frac=0.009,
    transports_per_h=121.0,
    waiting_frac=0.09,
    empty_travel_frac=0.41,
    bottleneck="nothing is short: 60 of 61 orders delivered; the busiest is machine M3, 71%",
    bottleneck_code="played_nothing_short",
    bottleneck_values={
        "delivered": 60,
        "placed": 61,
        "where": {"code": "played_machine", "values": {"name": "M3"}, "text": "machine M3"},
        "busy": 71,
    },
    bottleneck_name="",
    invariants="held",
)


class DraftView(msgspec.Struct, frozen=True, kw_only=True):
    """A draft of a plant, and its findings."""

    id: str
    name: str
    version: int
    """Also in `ETag`. A change names it in `If-Match`."""
    by: str
    at_s: float
    data: dict[str, Any]
    """A plant file of any shape; null means open. `closed` lists lanes not used in the draft, `plan` has the
    position of its floor plan."""
    findings: tuple[FindingView, ...]
    notes: tuple[NoteView, ...]
    """Oddities of the file that it was made from."""
    plan_type: str
    """Media type of its floor plan; empty if it has none."""


class PlanView(msgspec.Struct, frozen=True, kw_only=True):
    """A floor plan laid under a draft."""

    media_type: str
    """Media type of the stored picture; DXF becomes SVG."""
    width_m: float | None = None
    """Width, if the plan states its size, like DXF; else null."""
    height_m: float | None = None
    notes: tuple[NoteView, ...] = ()
    """Parts that were left out or assumed."""


PLAN_EXAMPLE = PlanView(
    media_type="image/svg+xml",
    width_m=84.2,
    height_m=51.0,
    notes=(
        NoteView(
            text="left out: MTEXT, 31 times", code="note_plan_left_out", values={"kind": "MTEXT", "count": 31}
        ),
    ),
)

EXAMPLE = DraftView(
    id="line-4",
    name="Line 4",
    version=7,
    by="Early shift",
    at_s=1_893_456_000.0,
    data={"plant": "line-4", "name": "Line 4", "machines": None},
    findings=(FindingView(level="open", field="machines", text="is open: what makes products"),),
    notes=(),
    plan_type="",
)
PLAY_EXAMPLE = PlayView(
    state="done", version=7, hours=4.0, seed=1, draft=EXAMPLE_FIGURES, running=EXAMPLE_FIGURES
)


class NewDraft(BaseModel):
    """A new draft."""

    model_config = ConfigDict(extra="forbid", json_schema_extra={"examples": [{"name": "Line 4"}]})

    name: Line
    file: str | None = None
    """Text of a plant file (YAML), a LIF file (JSON) or an openTCS plant model (XML); left out for the
    running plant."""
    file_base64: str | None = None
    """The file itself instead of its text, if its encoding may not be UTF-8."""
    file_name: Annotated[str, Field(max_length=200, pattern=NOTE)] = "draft"
    unit: Literal["", "m", "cm", "mm"] = ""
    """Unit of a LIF file; guessed if empty."""
    onto_running: Annotated[bool, Field(strict=True)] = False
    """Whether the running plant supplies what a layout lacks, where its nodes exist."""


class ChangedDraft(BaseModel):
    """A draft's new content."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={"examples": [{"name": "Line 4", "data": {"plant": "line-4", "name": "Line 4"}}]},
    )

    name: Line
    data: dict[str, Any]


class FloorPlan(BaseModel):
    """A picture to lay under a draft."""

    model_config = ConfigDict(
        extra="forbid",
        json_schema_extra={"examples": [{"media_type": "image/svg+xml", "base64": "PHN2Zy8+"}]},
    )

    media_type: str
    """image/png, image/svg+xml or image/vnd.dxf."""
    base64: str
    """The file; DXF may be gzipped."""


class Shift(BaseModel):
    """A shift to play."""

    model_config = ConfigDict(extra="forbid", json_schema_extra={"examples": [{"hours": 4, "seed": 1}]})

    hours: Annotated[float, Field(ge=0.05, le=LONGEST_H, allow_inf_nan=False)] = 4.0
    """Hours of demand: orders as `dray sim run day` draws them from the seed."""
    seed: Annotated[int, Field(ge=0, le=2**31)] = 1
