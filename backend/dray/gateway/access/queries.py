"""Queries: an unknown query parameter is refused, never ignored.

A client that asks for `?refrence=PO-17` and gets every order would take that for its answer. One middleware
stands before all calls under `/api`; the known parameters are the query parameters of the route.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from http import HTTPStatus

from fastapi.dependencies.models import Dependant
from fastapi.dependencies.utils import get_flat_params
from fastapi.params import Query
from fastapi.routing import iter_route_contexts
from starlette.datastructures import QueryParams
from starlette.routing import BaseRoute
from starlette.types import ASGIApp, Receive, Scope, Send

from dray.gateway.access.caller import ADMITTED
from dray.gateway.access.gate import refuse
from dray.gateway.http.problems import MAX_FIELD_ERRORS, FieldError, Problem

NAME_CHARS = 64
"""Maximum characters quoted of an unknown name: longer than any known one."""


class KnownQueries:
    """Refuses unknown query parameters; stands behind the gate.

    Args:
        app: the next application.
        routes: the application's routes; later additions count.
    """

    def __init__(self, app: ASGIApp, routes: Sequence[BaseRoute]) -> None:
        self._app, self._routes = app, routes
        self._known: dict[tuple[str, str], frozenset[str]] = {}
        """By method and path template; filled at the first request with a query."""

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        problem = _unknown(scope, self._known_to(scope)) if _asks(scope) else None
        if problem is None:
            await self._app(scope, receive, send)
        else:
            await refuse(problem, scope, receive, send)

    def _known_to(self, scope: Scope) -> frozenset[str]:
        if not self._known:
            self._known = dict(_parameters(self._routes))
        return self._known.get((scope.get("method", "GET"), scope[ADMITTED].template), frozenset())


def _asks(scope: Scope) -> bool:
    """Whether a request under `/api` has a query and was admitted by a rule."""
    return bool(scope.get("query_string")) and ADMITTED in scope and scope["path"].startswith("/api/")


def _unknown(scope: Scope, known: frozenset[str]) -> Problem | None:
    given = dict.fromkeys(name for name, _ in QueryParams(scope["query_string"]).multi_items())
    unknown = [name for name in given if name not in known]
    if not unknown:
        return None
    there_are = f"known here: {', '.join(sorted(known))}" if known else "none is known here"
    errors = [
        FieldError(name[:NAME_CHARS], f"there is no such parameter; {there_are}")
        for name in unknown[:MAX_FIELD_ERRORS]
    ]
    names = ", ".join(repr(error.field) for error in errors)
    return Problem(
        HTTPStatus.UNPROCESSABLE_ENTITY,
        "unknown-parameter",
        "The query has a parameter that this call does not know",
        f"{names}: there is no such parameter; {there_are}",
        errors=errors,
    )


def _parameters(routes: Sequence[BaseRoute]) -> Iterator[tuple[tuple[str, str], frozenset[str]]]:
    for route in iter_route_contexts(routes):
        dependant = getattr(route, "dependant", None)
        if route.path is None or not isinstance(dependant, Dependant):
            continue  # A file or the OpenAPI document: no parameters.
        names = frozenset(
            field.alias for field in get_flat_params(dependant) if isinstance(field.field_info, Query)
        )
        # A websocket begins as a GET.
        for method in route.methods or {"GET"}:
            yield (method, route.path), names
