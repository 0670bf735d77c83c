"""Checks of bodies before they are read, and patterns of safe texts."""

from __future__ import annotations

from email.message import Message
from http import HTTPStatus
from typing import Annotated

from fastapi import Request
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field
from pydantic_core import PydanticKnownError

from dray.gateway.http.problems import Problem

_UNSEEN = r"\x00-\x1f\x7f\u202a-\u202e\u2066-\u2069"
"""Control characters, which would spoil logs and tables, and bidirectional ones: U+202E makes a name read as
another one (Unicode, TR9 and TR36)."""

LINE = rf"^[^{_UNSEEN}]*[^ {_UNSEEN}][^{_UNSEEN}]*$"
"""One line of text with more than spaces."""

NOTE = rf"^[^{_UNSEEN}]*$"
"""One line of text, possibly empty."""

FORM = "application/x-www-form-urlencoded"

Line = Annotated[str, Field(min_length=1, max_length=200, pattern=LINE)]
"""A name or reference by people: long enough for a company and its department."""


def few(most: int) -> BeforeValidator:
    """A check for a mapping with `max_length`: counts its entries first, as pydantic does for lists.

    The faults of thousands of entries would block the event loop.
    """

    def check(value: object) -> object:
        if isinstance(value, dict) and len(value) > most:
            told = {"field_type": "Dictionary", "max_length": most, "actual_length": len(value)}
            raise PydanticKnownError("too_long", told)
        return value

    return BeforeValidator(check)


class RowsFile(BaseModel):
    """A spreadsheet, to be imported or only checked."""

    model_config = ConfigDict(extra="forbid")

    csv: str | None = None
    """Text of the file."""
    base64: str | None = None
    """The file itself instead, if its encoding may not be UTF-8."""
    dry_run: Annotated[bool, Field(strict=True)] = False
    """Whether to check it only."""


async def json_only(request: Request) -> None:
    """Refuse a body whose content type is not JSON.

    This also keeps other sites' pages out: browsers ask before a page may send JSON elsewhere.

    Raises:
        Problem: 415.
    """
    if request.headers.get("content-type") == "application/json":
        return
    header = Message()
    header["content-type"] = request.headers.get("content-type", "")
    kind = header.get_content_subtype()
    if header.get_content_maintype() == "application" and (kind == "json" or kind.endswith("+json")):
        return
    raise Problem(
        HTTPStatus.UNSUPPORTED_MEDIA_TYPE,
        "not-called-json",
        "The body is not called JSON",
        f"Content-Type is {request.headers.get('content-type', '')[:64]!r}; send application/json",
    )


async def json_or_nothing(request: Request) -> None:
    """As `json_only`, for a body that may be left out.

    Raises:
        Problem: 415.
    """
    if "transfer-encoding" in request.headers or request.headers.get("content-length", "0") != "0":
        await json_only(request)


async def read_form(request: Request, fields: int) -> dict[str, str]:
    """The text fields of a form.

    Args:
        request: the request with the form.
        fields: maximum fields.

    Raises:
        Problem: 415, the body is not a form.
    """
    kind = request.headers.get("content-type", "").partition(";")[0].strip().lower()
    if kind != FORM:
        raise Problem(
            HTTPStatus.UNSUPPORTED_MEDIA_TYPE,
            "not-called-form",
            "The body is not called a form",
            f"Content-Type is {kind[:64]!r}; send {FORM}",
        )
    form = await request.form(max_files=0, max_fields=fields)
    return {name: value for name, value in form.items() if isinstance(value, str)}
