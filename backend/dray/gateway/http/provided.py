"""The running gateway's services by type: routers and middleware name those they need, and get no others.

`app` makes the services and provides them (`provide`). A router takes one as a parameter, `store:
Provided[Store]`. Middleware has no parameters and calls `provided(scope["app"], Access)`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache
from typing import TYPE_CHECKING, Annotated, Any, TypeVar, cast

from fastapi import Depends
from starlette.applications import Starlette
from starlette.requests import HTTPConnection

T = TypeVar("T")


def provide(app: Starlette, services: Mapping[type[Any], object], wall_s: Callable[[], float]) -> None:
    """Make these services available by type, and the wall clock."""
    app.state.provided, app.state.wall_s = services, wall_s


def provided(app: Starlette, kind: type[T]) -> T:
    """The service of this type.

    Raises:
        KeyError: it is not provided, which is a mistake of ours.
    """
    return cast(T, app.state.provided[kind])


if TYPE_CHECKING:
    Provided = Annotated[T, "a service of the running gateway"]
else:

    class Provided:
        """A router's parameter: a service of the running gateway, by its type."""

        def __class_getitem__(cls, kind: type[T]) -> object:
            return Annotated[kind, _parameter(kind)]


@cache
def _parameter(kind: type[Any]) -> Any:
    """One dependency per type, so that a request looks each service up once."""

    async def service(connection: HTTPConnection) -> object:
        return connection.app.state.provided[kind]

    return Depends(service)


async def _now_s(connection: HTTPConnection) -> float:
    return cast(float, connection.app.state.wall_s())


Now = Annotated[float, Depends(_now_s)]
"""A router's parameter: the wall clock at the request, in seconds since 1970."""
