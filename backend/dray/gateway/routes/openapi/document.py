"""The OpenAPI document: FastAPI's description of the routers, with the shapes of our structs."""

from __future__ import annotations

from typing import Any

import msgspec
from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi

from dray import __version__
from dray.gateway.access.gate import COOKIE
from dray.gateway.access.rules import RULES, Rule
from dray.gateway.factory.area_pause import PauseAnswer
from dray.gateway.factory.closings import Outlook
from dray.gateway.factory.figures import KpiHistory
from dray.gateway.factory.plant_drafts import FindingView, NoteView
from dray.gateway.factory.promises import PromiseLedger
from dray.gateway.factory.shift_player import PlayView
from dray.gateway.factory.shift_report import ShiftReport
from dray.gateway.http.problems import FieldError, ProblemDetails
from dray.gateway.live.frames import COLLECTIONS, Delta, Snapshot
from dray.gateway.live.replay.knowledge import KnowledgeView
from dray.gateway.live.replay.reader import FilmView, OverviewView
from dray.gateway.live.views import (
    AlertRecord,
    AlertView,
    AtvView,
    ClosureView,
    FactoryView,
    FaultView,
    MachineView,
    ObstacleView,
    RemovalView,
    ScenarioView,
    TaskView,
    WaitView,
)
from dray.gateway.live.views.duty import DutyView
from dray.gateway.orders.feasibility import OrderPreview
from dray.gateway.routes.factory.command_answers import CommandAnswer
from dray.gateway.routes.factory.duty import CallAnswered
from dray.gateway.routes.factory.faults import FaultsAnswer
from dray.gateway.routes.factory.floor.traffic import TrafficAnswer
from dray.gateway.routes.factory.inventory import InventoryLine, MaterialAnswer, StorageAnswer
from dray.gateway.routes.factory.plant_draft_bodies import DraftView, PlanView
from dray.gateway.routes.history.audit import AuditLine
from dray.gateway.routes.history.events import EventAnswer
from dray.gateway.routes.history.kept import KeptView
from dray.gateway.routes.history.quality import QualityAnswer
from dray.gateway.routes.history.replay import SpellsView
from dray.gateway.routes.history.reports import TargetsView
from dray.gateway.routes.history.tasks import TaskRecord, TaskStory
from dray.gateway.routes.keys import KeyAnswer, NewKeyAnswer
from dray.gateway.routes.me import MeAnswer
from dray.gateway.routes.openapi.examples import examples
from dray.gateway.routes.orders.change_feed import ChangesAnswer
from dray.gateway.routes.orders.imports import ImportAnswer
from dray.gateway.routes.orders.links import LinksRevoked, NewLink
from dray.gateway.routes.orders.orders import OrderAnswer, PlacedOrder
from dray.gateway.routes.orders.schedules import RunsPreview, ScheduleAnswer
from dray.gateway.routes.orders.timeline import OrderStory
from dray.gateway.routes.orders.transports import TransportAnswer, TransportStory
from dray.gateway.routes.people import LoginLinkAnswer, PersonAnswer
from dray.gateway.routes.priorities import PrioritiesAnswer
from dray.gateway.routes.products.imports import ProductsAnswer
from dray.gateway.routes.products.products import ProductAnswer
from dray.gateway.routes.products.removal import DefinitionAnswer, RemovedProducts
from dray.gateway.tracking.answer import TrackAnswer
from dray.gateway.tracking.transport import TransportTrackAnswer
from dray.plant.model import PlantFile
from dray.store.factory.exclusions import Exclusion
from dray.store.factory.plant_drafts import DraftLine

SHAPES = (
    AlertView,
    AlertRecord,
    AtvView,
    AuditLine,
    ClosureView,
    CallAnswered,
    CommandAnswer,
    DefinitionAnswer,
    Delta,
    DutyView,
    DraftLine,
    DraftView,
    PlanView,
    EventAnswer,
    Exclusion,
    FactoryView,
    FaultsAnswer,
    FilmView,
    KnowledgeView,
    OverviewView,
    SpellsView,
    ShiftReport,
    TargetsView,
    FaultView,
    FindingView,
    NoteView,
    ImportAnswer,
    KeyAnswer,
    KpiHistory,
    LinksRevoked,
    LoginLinkAnswer,
    NewKeyAnswer,
    NewLink,
    InventoryLine,
    MachineView,
    MaterialAnswer,
    MeAnswer,
    PrioritiesAnswer,
    ObstacleView,
    OrderAnswer,
    PlacedOrder,
    OrderPreview,
    OrderStory,
    Outlook,
    PauseAnswer,
    PersonAnswer,
    PlantFile,
    PlayView,
    ProblemDetails,
    ProductAnswer,
    ProductsAnswer,
    PromiseLedger,
    QualityAnswer,
    RemovalView,
    RemovedProducts,
    RunsPreview,
    ScenarioView,
    ScheduleAnswer,
    Snapshot,
    StorageAnswer,
    TaskRecord,
    TaskStory,
    KeptView,
    TaskView,
    TrackAnswer,
    TrafficAnswer,
    ChangesAnswer,
    TransportAnswer,
    TransportStory,
    TransportTrackAnswer,
    WaitView,
)
"""Structs in routers' answers, and the frames of the stream."""

DESCRIPTION = """\
Orders for a factory without a dispatcher, and everything that can be seen of it.

* Lists come as `{"items": [...], "next_cursor": ...}`; ask again with `cursor` until it is null.
* Errors are `application/problem+json` (RFC 9457): `title`, `detail`, and `errors` per field.
* A query parameter that a call does not know is refused with 422, and those that it knows are named.
* Answers to GET name their state in `ETag`; asked again with `If-None-Match` they are 304 while nothing has changed.
* Times that end in `_at_s` are seconds since 1970 on the wall clock; `created_at`, `due_at` and
  `delivered_at` are the same in ISO 8601.
* `/api/stream` is a websocket: one `Snapshot`, then numbered `Delta`s, which tell new entities whole and of others what
  has changed; with `pace=calm` one a second. It is closed with 4401 when the session ends,
  and with 4409 when its station or areas have changed: another one shows what may be seen now.
* Programs send `Authorization: Bearer TOKEN`, with a key of `dray key create`; browsers have the cookie of
  `/login`. Each operation names the scope that it asks for.
"""

SECURITY = {
    "key": {"type": "http", "scheme": "bearer"},
    "session": {"type": "apiKey", "in": "cookie", "name": COOKIE},
}

SPARSE = frozenset({ProblemDetails.__name__, FieldError.__name__})
"""Structs that omit fields with default values."""

PROBLEM = {"application/problem+json": {"schema": {"$ref": "#/components/schemas/ProblemDetails"}}}


def install(app: FastAPI) -> None:
    """Make `app` describe itself in this way."""

    def document() -> dict[str, Any]:
        if app.openapi_schema is None:
            app.openapi_schema = _document(app)
        return app.openapi_schema

    app.openapi = document  # type: ignore[method-assign]  # FastAPI's documented way


def _document(app: FastAPI) -> dict[str, Any]:
    document = get_openapi(title="Dray", version=__version__, description=DESCRIPTION, routes=app.routes)
    _, shapes = msgspec.json.schema_components(SHAPES, ref_template="#/components/schemas/{name}")
    _tell_what_is_always_there(shapes)
    _tell_differences(shapes)
    schemas = document.setdefault("components", {}).setdefault("schemas", {})
    for replaced in ("HTTPValidationError", "ValidationError"):
        schemas.pop(replaced, None)
    schemas.update(shapes)
    _tell_what_is_seen(schemas[PlantFile.__name__])
    document["components"]["securitySchemes"] = SECURITY
    for template, path in document["paths"].items():
        for method, operation in path.items():
            _tell_problems(method, operation)
            if rule := RULES.get((method.upper(), template)):
                _tell_rule(rule, operation)
            _tell_shapes(operation)
    return document


def _tell_what_is_always_there(shapes: dict[str, Any]) -> None:
    """Mark all fields of answers as required.

    msgspec calls those with defaults optional, but answers always have them.
    """
    for name, shape in shapes.items():
        if "properties" in shape and name not in SPARSE:
            shape["required"] = list(shape["properties"])


def _tell_differences(shapes: dict[str, Any]) -> None:
    """Describe known entities in a delta: id and changes only, as `AtvPatch` for `AtvView`."""
    for collection in COLLECTIONS.values():
        entities = shapes[Delta.__name__]["properties"][collection]["items"]
        whole = _name(entities)
        part = whole.removesuffix("View") + "Patch"
        shapes[part] = shapes[whole] | {"title": part, "required": ["id"]}
        entities["$ref"] = entities["$ref"].removesuffix(whole) + part


def _tell_what_is_seen(plant: dict[str, Any]) -> None:
    """Allow empty lists in a plant: the part that a caller sees may have none of a kind."""
    for part in plant["properties"].values():
        part.pop("minItems", None)


def _tell_problems(method: str, operation: dict[str, Any]) -> None:
    """Add the refusals of every operation: for unknown parameters, and for invalid bodies."""
    refusals = {"422": "Some fields cannot be used, or the query has a parameter that is not known here"}
    if method == "post":
        refusals |= {"403": "Another site's page asked", "413": "The body is too large"}
    if "requestBody" in operation:
        refusals |= {
            "400": "The body is not JSON",
            "415": "The body is not called JSON",
        }
    operation["responses"].pop("422", None)
    for status, description in refusals.items():
        operation["responses"][status] = {"description": description, "content": PROBLEM}


def _tell_rule(rule: Rule, operation: dict[str, Any]) -> None:
    """Add the required right, and the refusals without it."""
    if rule.public:
        operation["security"] = []
        return
    scopes = [] if rule.scope is None else [rule.scope.value]
    operation["security"] = [{name: scopes} for name in SECURITY]
    if scopes:
        operation["description"] += f"\n\nScope: `{scopes[0]}`."
    answers = operation["responses"]
    forbidden = [answers["403"]["description"]] if "403" in answers else []
    refusals = {
        "401": "Nobody is logged in, or not any more",
        "403": "; ".join((*forbidden, "The caller may not do this")),
        "429": "Too many requests",
    }
    for status, description in refusals.items():
        answers[status] = {"description": description, "content": PROBLEM}


def _tell_shapes(operation: dict[str, Any]) -> None:
    """Correct the shapes of encoded answers, which FastAPI takes for text, and add examples."""
    for answer in operation["responses"].values():
        content = answer.get("content", {}).get("application/json", {})
        schema = content.get("schema", {})
        if "$ref" in schema:
            schema.pop("type", None)
            name = _name(schema)
            given = content.get("example")
            content["example"] = examples()[name] if given is None else _with_nulls(given, name)
        elif "items" in schema.get("properties", {}):
            items = [examples()[_name(schema["properties"]["items"]["items"])]]
            content["example"] = {"items": items, "next_cursor": None}
            if "total" in schema.get("properties", ()):
                content["example"]["total"] = len(items)


def _with_nulls(example: dict[str, Any], name: str) -> object:
    """An example as its struct writes it, with the nulls that FastAPI leaves out."""
    shape = next(shape for shape in SHAPES if shape.__name__ == name)
    return msgspec.to_builtins(msgspec.convert(example, shape))


def _name(reference: dict[str, Any]) -> str:
    name: str = reference["$ref"].rpartition("/")[2]
    return name
