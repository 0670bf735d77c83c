"""The caller, as recognised by the gate, for routers."""

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
"""Scope key of the rule's row that admitted a request, set by the gate."""

CALLER = "dray.caller"
"""Scope key of the principal, if any."""

_log = logging.getLogger(__name__)


def admit(scope: Scope, found: Found, principal: Principal | None) -> None:
    """Mark a request as admitted."""
    scope[ADMITTED], scope[CALLER] = found, principal


def takes_files(scope: Scope) -> bool:
    """Whether the request's route takes a whole file as its body."""
    found: Found | None = scope.get(ADMITTED)
    return found is not None and found.rule.bulk


async def admitted(connection: HTTPConnection) -> None:
    """Dependency of every route: refuse requests that the gate has not admitted by this route's own row.

    Raises:
        Problem: the row is missing, a mistake of ours; the log names the route.
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
    """The caller; only for routes that are not public."""
    principal = connection.scope[CALLER]
    assert isinstance(principal, Principal)  # noqa: S101 - nobody else passes the gate
    return principal


async def _caller(connection: HTTPConnection) -> Principal:
    return caller_of(connection)


Caller = Annotated[Principal, Depends(_caller)]
"""A router's parameter."""
