"""Problems: every error answer of the gateway, by RFC 9457.

Each tells what was wrong (`title`), where (`detail`, `errors`) and what to do. `type` names the kind of
problem for programs.
"""

from __future__ import annotations

import json
import logging
from collections.abc import Iterable, Mapping, Sequence
from http import HTTPStatus
from itertools import islice
from typing import Any

import msgspec
from fastapi import FastAPI, Request, Response
from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException
from starlette.routing import BaseRoute, Match, Mount
from starlette.types import Scope

from dray.errors import DrayError, UnavailableError
from dray.gateway.http.fault_codes import code_of, text_of, words_of
from dray.messages.base import encodable

MEDIA_TYPE = "application/problem+json"

MAX_FIELD_ERRORS = 50
"""Maximum faults reported at once: more usually have one cause."""

AGAIN_S = 5
"""Seconds before a retry while the database is away: about the time of a server restart."""

AWAY = "database-away"
"""Kind of the problem of an absent database."""

CHALLENGE = {"WWW-Authenticate": 'Bearer realm="Dray"'}
"""Header that tells how to authenticate, required in every answer 401 (RFC 9110, 15.5.2)."""

_log = logging.getLogger(__name__)


class FieldError(msgspec.Struct, frozen=True, omit_defaults=True):
    """One invalid field."""

    field: str
    """Path such as `items[0].quantity`."""
    reason: str
    """What is wrong, and what would be right."""
    code: str = ""
    """Code of the reason (`http.fault_codes`); empty if it has none."""
    values: dict[str, str] = {}
    """Values for the reason."""

    @classmethod
    def of(cls, field: str, code: str, /, **values: object) -> FieldError:
        """A fault with a code."""
        given = {name: str(value) for name, value in values.items()}
        return cls(field, text_of(code, given), code, given)


class ProblemDetails(msgspec.Struct, frozen=True, omit_defaults=True):
    """An error answer (RFC 9457)."""

    type: str
    """`urn:dray:problem:` and the kind of problem."""
    title: str
    """Kind of problem in words; always the same for one type."""
    status: int
    """The HTTP status."""
    detail: str
    """What was wrong this time, and what to do."""
    instance: str = ""
    """Path of the request."""
    errors: tuple[FieldError, ...] = ()
    """Single faults, if any."""


class Problem(DrayError):
    """An error for the caller.

    Args:
        status: the HTTP status.
        kind: a short name, such as `unknown-order`.
        title: the kind in words.
        detail: what was wrong this time, and what to do.
        errors: single faults.
        headers: headers of the answer.
    """

    def __init__(
        self,
        status: int,
        kind: str,
        title: str,
        detail: str,
        *,
        errors: Sequence[FieldError] = (),
        headers: Mapping[str, str] | None = None,
    ) -> None:
        self.status, self.kind, self.title, self.detail = status, kind, title, detail
        self.errors, self.headers = tuple(errors), dict(headers or {})
        super().__init__(f"{title}: {detail}")

    def response(self, path: str) -> Response:
        """The answer to a request for `path`."""
        details = ProblemDetails(
            type=f"urn:dray:problem:{self.kind}",
            title=self.title,
            status=self.status,
            detail=self.detail,
            instance=path,
            errors=self.errors,
        )
        try:
            body = msgspec.json.encode(details)
        except UnicodeEncodeError:
            # A refused file's content, such as a lone surrogate, may be quoted in its faults.
            body = encodable(json.dumps(msgspec.to_builtins(details), ensure_ascii=False)).encode()
        return Response(body, self.status, headers=self.headers, media_type=MEDIA_TYPE)


def unusable(*errors: FieldError) -> Problem:
    """The problem of a well-formed request with invalid fields."""
    first = errors[0]
    more = f" (and {len(errors) - 1} more)" if len(errors) > 1 else ""
    return Problem(
        HTTPStatus.UNPROCESSABLE_ENTITY,
        "unusable-fields",
        "Some fields cannot be used",
        f"{first.field}: {first.reason}{more}",
        errors=errors,
    )


def unusable_fields(faults: Iterable[Mapping[str, Any]]) -> Problem:
    """The problem of a request with pydantic faults; reports the first `MAX_FIELD_ERRORS`."""
    return unusable(*map(field_error, islice(faults, MAX_FIELD_ERRORS)))


def not_found(noun: str, name: str, where: str) -> Problem:
    """The problem of an unknown id.

    Args:
        noun: the kind of thing, such as `order`.
        name: the id in the request.
        where: the list that has all ids.
    """
    return Problem(
        HTTPStatus.NOT_FOUND,
        f"unknown-{noun}",
        f"There is no such {noun}",
        f"no {noun} has the id {name[:64]!r}; {where} lists those there are",
    )


def install(app: FastAPI) -> None:
    """Turn every error of `app` into a problem; `on_bug` is for a middleware."""
    app.add_exception_handler(Problem, _on_problem)
    app.add_exception_handler(RequestValidationError, _on_validation)
    app.add_exception_handler(HTTPException, on_http)
    app.add_exception_handler(UnavailableError, _on_unavailable)


async def _on_problem(request: Request, error: Exception) -> Response:
    assert isinstance(error, Problem)  # noqa: S101 - it was registered for these only
    return error.response(request.url.path)


async def _on_validation(request: Request, error: Exception) -> Response:
    assert isinstance(error, RequestValidationError)  # noqa: S101 - it was registered for these only
    faults = error.errors()
    for fault in faults:
        if fault["type"] == "json_invalid":
            why = fault.get("ctx", {}).get("error", "it cannot be read")
            return not_json(fault["loc"][-1], why).response(request.url.path)
    # The first part of the location is the source: body, query or path.
    told = ({**fault, "loc": fault["loc"][1:]} for fault in faults)
    return unusable_fields(told).response(request.url.path)


async def on_http(request: Request, error: Exception) -> Response:
    """The problem of an address or method without a route, or of an unreadable request."""
    assert isinstance(error, HTTPException)  # noqa: S101 - it was registered for these only
    path = request.url.path
    status, headers = HTTPStatus(error.status_code), dict(error.headers or {})
    match status:
        case HTTPStatus.NOT_FOUND:
            detail = f"there is nothing at {path}; /api/docs tells what there is"
        case HTTPStatus.METHOD_NOT_ALLOWED:
            headers["Allow"] = ", ".join(_allowed(request))
            if request.method == "OPTIONS":
                return Response(status_code=HTTPStatus.NO_CONTENT, headers=headers)
            detail = f"{path} does not know {request.method}; use {headers['Allow']}"
        case HTTPStatus.BAD_REQUEST:
            detail = "the body cannot be read as JSON in UTF-8; see /api/docs"
        case _:
            detail = str(error.detail)
    kind = status.phrase.lower().replace(" ", "-")
    return Problem(status, kind, status.phrase, detail, headers=headers).response(path)


async def _on_unavailable(request: Request, _error: Exception) -> Response:
    return away().response(request.url.path)


def away() -> Problem:
    """The problem of an absent database.

    Its cause is logged once per outage (`dray.store.database.database`).
    """
    return Problem(
        HTTPStatus.SERVICE_UNAVAILABLE,
        AWAY,
        "The database does not answer",
        "try again in some seconds; an order that is sent again under its Idempotency-Key is taken once",
        headers={"Retry-After": str(AGAIN_S)},
    )


async def on_bug(request: Request, error: Exception) -> Response:
    """The problem of our own bug: the details are only in the log."""
    _log.error("bug while answering %s %s", request.method, request.url.path, exc_info=error)
    return Problem(
        HTTPStatus.INTERNAL_SERVER_ERROR,
        "bug",
        "Dray has made a mistake",
        "it is in the log; try again, and report it if it happens again",
    ).response(request.url.path)


def field_error(fault: Mapping[str, Any]) -> FieldError:
    """A pydantic error as a field error."""
    return FieldError(_field(fault["loc"]), _reason(fault), *code_of(fault))


def _allowed(request: Request) -> list[str]:
    """All methods of this path: the router names only those of the first match."""
    # A mount has moved the scope's root to itself.
    scope = {**request.scope, "root_path": request.scope.get("app_root_path", "")}
    return [
        method
        for method in ("GET", "POST", "PUT", "PATCH", "DELETE")
        if any(_takes(route, scope | {"method": method}) for route in request.app.routes)
    ]


def _takes(route: BaseRoute, scope: Scope) -> bool:
    """Whether a route takes this method. A mount matches any method, but ours holds read-only files."""
    if isinstance(route, Mount) and scope["method"] != "GET":
        return False
    return route.matches(scope)[0] is Match.FULL


def not_json(place: int, why: str) -> Problem:
    """The problem of a body that is not JSON.

    Args:
        place: position of the first unreadable character.
        why: what is wrong there.
    """
    return Problem(
        HTTPStatus.BAD_REQUEST,
        "not-json",
        "The body is not JSON",
        f"at character {place}: {why}; send one JSON object in UTF-8",
    )


def _field(location: Sequence[str | int]) -> str:
    """The location of a fault, as `items[0].quantity`."""
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in location)
    return text.removeprefix(".") or "body"


def _reason(fault: Mapping[str, Any]) -> str:
    match fault["type"]:
        case "extra_forbidden":
            return "there is no such field; see /api/docs"
        case _:
            if (words := words_of(fault)) is not None:
                return words
            message = str(fault["msg"]).removeprefix("Value error, ")
            return message[:1].lower() + message[1:]
