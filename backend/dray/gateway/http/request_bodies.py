"""What every body must be before anybody looks into it, and texts that may be kept and shown."""

from __future__ import annotations

from email.message import Message
from http import HTTPStatus
from typing import Annotated

from fastapi import Request
from pydantic import Field

from dray.gateway.http.problems import Problem

LINE = r"^[^\x00-\x1f\x7f]*[^\x00-\x20\x7f][^\x00-\x1f\x7f]*$"
"""One line of text that is more than spaces: control characters would spoil logs and tables."""

Line = Annotated[str, Field(min_length=1, max_length=200, pattern=LINE)]
"""A name or reference that people write: long enough for a company and its department."""


async def json_only(request: Request) -> None:
    """Refuse a body that does not call itself JSON.

    It also keeps other sites' pages out: browsers let a page send JSON elsewhere only after asking.

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
