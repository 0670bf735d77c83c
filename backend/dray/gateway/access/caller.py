"""The caller: who asks, as the gate has recognised it, for routers."""

from __future__ import annotations

import logging
from http import HTTPStatus
from typing import Annotated

from fastapi import Depends
from starlette.requests import HTTPConnection
from starlette.types import Scope

from dray.gateway.access.principal import Principal
from dray.gateway.access.rules import Found
from dray.gateway.http.problems import Problem

ADMITTED = "dray.admitted"
"""Under this name the gate leaves the row by which it let a request pass..."""

CALLER = "dray.caller"
"""...and under this one the principal, where there is one."""

_log = logging.getLogger(__name__)


def admit(scope: Scope, found: Found, principal: Principal | None) -> None:
    """Note on a request that it may pass."""
    scope[ADMITTED], scope[CALLER] = found, principal


def takes_files(scope: Scope) -> bool:
    """Whether a request came to a route whose body may be a whole file."""
    found: Found | None = scope.get(ADMITTED)
    return found is not None and found.rule.bulk


async def admitted(connection: HTTPConnection) -> None:
    """Of every route: refuse what the gate has not let pass by the row of this very route.

    Raises:
        Problem: there is no such row, which is a mistake of ours; the log names the route.
    """
    found = connection.scope.get(ADMITTED)
    if found is None or set(found.parameters) != set(connection.path_params):
        _log.error("no row in dray.gateway.access.rules for %s", connection.url.path)
        raise Problem(
            HTTPStatus.FORBIDDEN,
            "no-rule",
            "Nobody may do this yet",
            "no rule says who may; report it",
        )


def caller_of(connection: HTTPConnection) -> Principal:
    """Who asks. Only for routes that are not public."""
    principal = connection.scope[CALLER]
    assert isinstance(principal, Principal)  # noqa: S101 - nobody else passes the gate
    return principal


async def _caller(connection: HTTPConnection) -> Principal:
    return caller_of(connection)


Caller = Annotated[Principal, Depends(_caller)]
"""A router's parameter."""
