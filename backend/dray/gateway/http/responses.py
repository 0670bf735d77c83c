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
"""Items per page: 500 tasks with their bids are some 5 MB, which a browser can still take."""

CURSOR_MOST = 2_048
"""Letters of a cursor. The longest says a customer of 200 letters, each of which JSON may write as six, and the id of an order."""

Cursor = Annotated[
    str | None, Query(max_length=CURSOR_MOST, description="`next_cursor` of the page before; opaque")
]

AT_ONCE = 50
"""Items that are encoded in one step of the event loop: some milliseconds, with all the bids that a task may have."""

PIECE_BYTES = 2**16
"""Of a body that is sent in pieces: to compress one takes some milliseconds."""

PAGE = 100
"""Items per page when nobody asks for another number."""


class Json(Response):
    """JSON that is encoded already, or a struct to encode."""

    media_type = "application/json"

    def render(self, content: Any) -> bytes:
        """Bytes as they are, anything else encoded."""
        return content if isinstance(content, bytes) else msgspec.json.encode(content)


def iso(wall_s: float) -> str:
    """A moment in ISO 8601, in UTC."""
    return datetime.fromtimestamp(wall_s, UTC).isoformat(timespec="milliseconds").replace("+00:00", "Z")


def listing(items: Sequence[object], next_cursor: str | None) -> Json:
    """One page of a list."""
    return Json({"items": items, "next_cursor": next_cursor})


def listing_in_turns(
    names: Sequence[str], now: Callable[[str], object | None], next_cursor: str | None
) -> Response:
    """The same, of what may have much in it, as tasks have bids: a long page is written piece by piece, with others' turns between, and has no `ETag`.

    Args:
        names: of its items.
        now: an item as it is at this moment; None when it does not belong there any more.
        next_cursor: of the next page.
    """
    return _told_in_turns(names, now, {"next_cursor": next_cursor})


def counted_in_turns(
    items: Sequence[T], told: Callable[[T], object], next_cursor: str | None, total: int | None
) -> Response:
    """The same, of a list of which it is told how many there are on all pages, as `counted`.

    Args:
        items: of this page.
        told: one of them, as it is answered.
        next_cursor: of the next page.
        total: of the list; None where that is not cheap.
    """
    return _told_in_turns(items, told, {"next_cursor": next_cursor, "total": total})


def _told_in_turns(
    items: Sequence[T], told: Callable[[T], object | None], rest: Mapping[str, object]
) -> Response:
    if len(items) <= PAGE:
        return Json({"items": [each for item in items if (each := told(item)) is not None], **rest})

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

    return StreamingResponse(pieces(), media_type=Json.media_type)


def in_turns(body: bytes) -> Response:
    """JSON that is encoded already: one that is long is sent piece by piece, with others' turns between, and has no `ETag`.

    To hash or compress all of it at once would hold the event loop for seconds.
    """
    if len(body) <= PIECE_BYTES:
        return Json(body)

    async def pieces() -> AsyncIterator[bytes]:
        for at in range(0, len(body), PIECE_BYTES):
            yield body[at : at + PIECE_BYTES]
            await asyncio.sleep(0)

    return StreamingResponse(pieces(), media_type=Json.media_type)


def counted(items: Sequence[object], next_cursor: str | None, total: int | None) -> Json:
    """One page of a list of which it is told how many there are on all pages; None where that is not cheap."""
    return Json({"items": items, "next_cursor": next_cursor, "total": total})


def write_cursor(*position: str | float) -> str:
    """A cursor that stands behind `position`."""
    return urlsafe_b64encode(msgspec.json.encode(position)).decode().rstrip("=")


def read_cursor(cursor: str | None, shape: type[Place]) -> Place | None:
    """What `write_cursor` was given.

    Args:
        cursor: from the request.
        shape: the tuple type that it must hold.

    Raises:
        Problem: it is not one of ours.
    """
    if cursor is None:
        return None
    try:
        padded = cursor + "=" * (-len(cursor) % 4)
        place: Place = msgspec.json.decode(urlsafe_b64decode(padded), type=shape)
        # No text that is kept has a NUL in it, and PostgreSQL takes none.
        if not any(isinstance(part, str) and "\0" in part for part in place):
            return place
    except (ValueError, msgspec.MsgspecError):
        pass
    raise unusable(
        FieldError("cursor", "it is not from this list; take next_cursor of the page before, or leave it out")
    )


def page(items: Sequence[T], name: Callable[[T], str], cursor: str | None, limit: int) -> Json:
    """One page of a list that is in memory.

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
    """What is on one page of a list that is in memory, and the cursor of the next one: see `page`.

    Raises:
        Problem: the cursor is not one of ours.
    """
    after = read_cursor(cursor, tuple[str])
    rest = [item for item in items if after is None or name(item) > after[0]]
    last = rest[limit - 1] if len(rest) > limit else None
    return rest[:limit], None if last is None else write_cursor(name(last))


def described(shape: type[object], description: str, example: object | None = None) -> dict[str, Any]:
    """How OpenAPI tells of an answer; `dray.gateway.routes.openapi.document` writes the shape into the document."""
    content: dict[str, Any] = {"schema": {"$ref": f"#/components/schemas/{shape.__name__}"}}
    if example is not None:
        content["example"] = msgspec.to_builtins(example)
    return {"description": description, "content": {"application/json": content}}


def list_of(shape: type[object], description: str) -> dict[str, Any]:
    """How OpenAPI tells of a page of a list."""
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
    """How OpenAPI tells of a page of a list of which it is told how many there are."""
    answer = list_of(shape, description)
    schema = answer["content"]["application/json"]["schema"]
    schema["required"].append("total")
    schema["properties"]["total"] = {
        "anyOf": [{"type": "integer"}, {"type": "null"}],
        "description": "How many there are on all pages; null for more than 10,000, and where words are looked for on several pages",
    }
    return answer


def problems(**kinds: str) -> Mapping[int | str, dict[str, Any]]:
    """How OpenAPI tells of problems.

    Args:
        kinds: as `p404="There is no such order"`.
    """
    schema = {"$ref": "#/components/schemas/ProblemDetails"}
    return {
        int(status[1:]): {
            "description": description,
            "content": {"application/problem+json": {"schema": schema}},
        }
        for status, description in kinds.items()
    }
