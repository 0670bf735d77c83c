"""Answers: structs as JSON, and lists in pages with opaque cursors."""

from __future__ import annotations

import asyncio
from base64 import urlsafe_b64decode, urlsafe_b64encode
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from datetime import UTC, datetime
from typing import Annotated, Any, TypeVar

import msgspec
from fastapi import Query, Response
from fastapi.responses import StreamingResponse

from dray.gateway.http.problems import FieldError, unusable

T = TypeVar("T")

Place = TypeVar("Place", bound=tuple[Any, ...])

Limit = Annotated[int, Query(ge=1, le=500, description="Items per page")]
"""Items per page: 500 tasks with their bids are some 5 MB, which a browser can handle."""

CURSOR_MOST = 2_048
"""Maximum characters of a cursor. The longest has a customer of 200 characters, each up to six in JSON, and
an order's id."""

Cursor = Annotated[
    str | None, Query(max_length=CURSOR_MOST, description="`next_cursor` of the page before; opaque")
]

AT_ONCE = 20
"""Items encoded per step of the event loop: some milliseconds, with all bids that a task may have."""

PIECE_BYTES = 2**16
"""Maximum bytes per piece of a body: compressing one takes some milliseconds."""

PAGE = 100
"""Default items per page."""


class Json(Response):
    """Encoded JSON, or a struct to encode."""

    media_type = "application/json"

    def render(self, content: Any) -> bytes:
        """Bytes unchanged, anything else encoded."""
        return content if isinstance(content, bytes) else msgspec.json.encode(content)


def iso(wall_s: float) -> str:
    """A wall clock time in ISO 8601, in UTC."""
    return datetime.fromtimestamp(wall_s, UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")


def listing(items: Sequence[object], next_cursor: str | None) -> Json:
    """One page of a list."""
    return Json({"items": items, "next_cursor": next_cursor})


async def listing_in_turns(
    items: Sequence[T], told: Callable[[T], object | None], next_cursor: str | None
) -> Response:
    """One page of items that may be large, such as tasks with bids.

    Other work runs in between. A long page is streamed in pieces, and has no `ETag`.

    Args:
        items: items of this page, or their names.
        told: turns one into its answer as it is now; None if it is no longer part of the list.
        next_cursor: cursor of the next page.
    """
    return await _told_in_turns(items, told, {"next_cursor": next_cursor})


async def counted_in_turns(
    items: Sequence[T], told: Callable[[T], object], next_cursor: str | None, total: int | None
) -> Response:
    """One page of a list with its total, like `counted`, streamed like `listing_in_turns`.

    Args:
        items: items of this page.
        told: turns an item into its answer.
        next_cursor: cursor of the next page.
        total: total of the list; None if it is expensive.
    """
    return await _told_in_turns(items, told, {"next_cursor": next_cursor, "total": total})


async def _told_in_turns(
    items: Sequence[T], told: Callable[[T], object | None], rest: Mapping[str, object]
) -> Response:
    async def pieces() -> AsyncIterator[bytes]:
        yield b'{"items":['
        before = b""
        for at in range(0, len(items), AT_ONCE):
            portion = [each for item in items[at : at + AT_ONCE] if (each := told(item)) is not None]
            if portion:
                yield before + b",".join(map(msgspec.json.encode, portion))
                before = b","
            await asyncio.sleep(0)
        yield b"]," + msgspec.json.encode(rest)[1:]

    if len(items) <= PAGE:
        return Json(b"".join([piece async for piece in pieces()]))
    return StreamingResponse(pieces(), media_type=Json.media_type)


def in_turns(body: bytes) -> Response:
    """Encoded JSON: a long body is sent in pieces, lets other work run, and has no `ETag`.

    Hashing or compressing all at once would block the event loop for seconds.
    """
    if len(body) <= PIECE_BYTES:
        return Json(body)

    async def pieces() -> AsyncIterator[bytes]:
        for at in range(0, len(body), PIECE_BYTES):
            yield body[at : at + PIECE_BYTES]
            await asyncio.sleep(0)

    return StreamingResponse(pieces(), media_type=Json.media_type)


def counted(items: Sequence[object], next_cursor: str | None, total: int | None) -> Json:
    """One page of a list with the total over all pages; None if that is expensive."""
    return Json({"items": items, "next_cursor": next_cursor, "total": total})


def write_cursor(*position: str | float) -> str:
    """A cursor behind `position`."""
    return urlsafe_b64encode(msgspec.json.encode(position)).decode().rstrip("=")


def read_cursor(cursor: str | None, shape: type[Place]) -> Place | None:
    """The position in a cursor of `write_cursor`.

    Args:
        cursor: from the request.
        shape: the expected tuple type.

    Raises:
        Problem: the cursor is not one of ours.
    """
    if cursor is None:
        return None
    try:
        padded = cursor + "=" * (-len(cursor) % 4)
        place: Place = msgspec.json.decode(urlsafe_b64decode(padded), type=shape)
        # No stored text has a NUL, and PostgreSQL accepts none.
        if not any(isinstance(part, str) and "\0" in part for part in place):
            return place
    except (ValueError, msgspec.MsgspecError):
        pass
    raise unusable(
        FieldError("cursor", "it is not from this list; take next_cursor of the page before, or leave it out")
    )


def page(items: Sequence[T], name: Callable[[T], str], cursor: str | None, limit: int) -> Json:
    """One page of a list in memory.

    Args:
        items: sorted by name.
        name: the name of an item, unique in the list.
        cursor: from the request.
        limit: items per page.

    Raises:
        Problem: the cursor is not one of ours.
    """
    return listing(*part(items, name, cursor, limit))


def part(
    items: Sequence[T], name: Callable[[T], str], cursor: str | None, limit: int
) -> tuple[Sequence[T], str | None]:
    """The items of one page of a list in memory, and the next page's cursor: see `page`.

    Raises:
        Problem: the cursor is not one of ours.
    """
    after = read_cursor(cursor, tuple[str])
    rest = [item for item in items if after is None or name(item) > after[0]]
    last = rest[limit - 1] if len(rest) > limit else None
    return rest[:limit], None if last is None else write_cursor(name(last))


def described(shape: type[object], description: str, example: object | None = None) -> dict[str, Any]:
    """An answer for OpenAPI; `dray.gateway.routes.openapi.document` adds the shape to the document."""
    content: dict[str, Any] = {"schema": {"$ref": f"#/components/schemas/{shape.__name__}"}}
    if example is not None:
        content["example"] = msgspec.to_builtins(example)
    return {"description": description, "content": {"application/json": content}}


def created_once(shape: type[object], what: str, example: object) -> dict[str, Any]:
    """The answer to a request with an Idempotency-Key, for OpenAPI: something is on disk."""
    headers = {
        "Location": {"description": what, "schema": {"type": "string"}},
        "Idempotency-Replayed": {
            "description": "`true` when this is the answer to an earlier request",
            "schema": {"type": "string"},
        },
    }
    return described(shape, f"{what} is on disk", example) | {"headers": headers}


def list_of(shape: type[object], description: str) -> dict[str, Any]:
    """A page of a list for OpenAPI."""
    schema = {
        "type": "object",
        "required": ["items", "next_cursor"],
        "properties": {
            "items": {"type": "array", "items": {"$ref": f"#/components/schemas/{shape.__name__}"}},
            "next_cursor": {"anyOf": [{"type": "string"}, {"type": "null"}]},
        },
    }
    return {"description": description, "content": {"application/json": {"schema": schema}}}


def counted_list_of(shape: type[object], description: str) -> dict[str, Any]:
    """A page of a list with its total for OpenAPI."""
    answer = list_of(shape, description)
    schema = answer["content"]["application/json"]["schema"]
    schema["required"].append("total")
    schema["properties"]["total"] = {
        "anyOf": [{"type": "integer"}, {"type": "null"}],
        "description": "How many there are on all pages; null for more than 10,000, and where words are looked for on several pages",
    }
    return answer


def problems(**kinds: str) -> Mapping[int | str, dict[str, Any]]:
    """Problems for OpenAPI.

    Args:
        kinds: descriptions such as `p404="There is no such order"`.
    """
    schema = {"$ref": "#/components/schemas/ProblemDetails"}
    return {
        int(status[1:]): {
            "description": description,
            "content": {"application/problem+json": {"schema": schema}},
        }
        for status, description in kinds.items()
    }
