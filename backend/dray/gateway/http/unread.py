"""Bodies as large as a file, not parsed on the event loop: a megabyte of JSON takes tenths of a second.

A router with such routes uses `UnreadRoute`. Its routes take the body as bytes with the model to read it as:
`body: Annotated[bytes, Body(), Unread(NewDraft)]`. Side work reads it (`read`), and refuses it as FastAPI
would.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Coroutine
from http import HTTPStatus
from typing import Any, TypeVar

from fastapi import Request, Response
from fastapi.routing import APIRoute
from pydantic import BaseModel, GetCoreSchemaHandler, ValidationError
from pydantic_core import CoreSchema, core_schema
from starlette.exceptions import HTTPException

from dray.gateway.http.problems import not_json, unusable_fields

M = TypeVar("M", bound=BaseModel)


class Unread:
    """Names the model of a body, for OpenAPI.

    Args:
        model: the body's model.
    """

    def __init__(self, model: type[BaseModel]) -> None:
        self._model = model

    def __get_pydantic_core_schema__(self, _source: object, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_wrap_validator_function(
            lambda body, _read: body, handler.generate_schema(self._model)
        )


class UnreadRoute(APIRoute):
    """A route that leaves its body unparsed."""

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        handle = super().get_route_handler()

        async def unread(request: Request) -> Response:
            return await handle(_Unread(request.scope, request.receive))

        return unread


class _Unread(Request):
    async def json(self) -> Any:
        return await self.body()


def read(model: type[M], body: bytes) -> M:
    """Read a body.

    Raises:
        Problem: it is not JSON, or has another shape.
        HTTPException: 400, it is not text, or nested too deep.
    """
    try:
        value = json.loads(body)
    except json.JSONDecodeError as error:
        raise not_json(error.pos, error.msg) from None
    except (ValueError, RecursionError):
        raise HTTPException(HTTPStatus.BAD_REQUEST) from None
    try:
        return model.model_validate(value, from_attributes=True)
    except ValidationError as error:
        raise unusable_fields(error.errors(include_url=False)) from None
