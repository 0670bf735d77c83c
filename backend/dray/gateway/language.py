"""The language of a page: what its address asks for, else what was chosen last, else what the browser wants.

The panels' scripts read and write the same cookie, so it is not hidden from them; it holds no secret.
"""

from __future__ import annotations

from starlette.requests import Request
from starlette.responses import Response

from dray.gateway.tracking.texts import choose

COOKIE = "dray_language"

REMEMBERED_S = 365 * 86_400
"""How long a browser remembers the language that was chosen."""


def language_of(request: Request) -> str:
    """The language that the answer to this request is written in."""
    return choose(
        request.query_params.get("lang", ""),
        request.cookies.get(COOKIE, ""),
        request.headers.get("accept-language", ""),
    )


def remember_language(answer: Response, request: Request) -> None:
    """Keep the language that the address asks for, if it asks for one."""
    language = language_of(request)
    if request.query_params.get("lang") != language:
        return
    answer.set_cookie(
        COOKIE,
        language,
        max_age=REMEMBERED_S,
        path="/",
        secure=request.url.scheme == "https",
        samesite="lax",
    )
