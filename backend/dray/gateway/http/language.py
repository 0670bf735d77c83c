"""The language of a page: what its address asks for, else what was chosen last, else what the browser wants.

The panels' scripts read and write the same cookie, so it is not hidden from them; it holds no secret.
"""

from __future__ import annotations

from collections.abc import Mapping

import msgspec
from starlette.requests import Request
from starlette.responses import Response

LANGUAGES: Mapping[str, str] = {"en": "English", "de": "Deutsch", "es": "Español"}
"""Those in which pages are written, each named in itself."""

FALLBACK = "en"

HEADER_CHARS = 500
"""Of an Accept-Language header: more than any browser sends."""

COOKIE = "dray_language"

REMEMBERED_S = 365 * 86_400
"""How long a browser remembers the language that was chosen."""


class Switch(msgspec.Struct, frozen=True):
    """A language to choose."""

    code: str
    name: str
    chosen: bool


def switches(language: str) -> tuple[Switch, ...]:
    """All languages, and which one is chosen."""
    return tuple(Switch(code, name, code == language) for code, name in LANGUAGES.items())


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


def choose(chosen: str, remembered: str, accepted: str) -> str:
    """The language of a page.

    Args:
        chosen: by the address; empty when not at all.
        remembered: by a cookie; empty when not at all.
        accepted: the Accept-Language header (RFC 9110, 12.5.4), however malformed.
    """
    for wanted in (chosen, remembered, *_by_preference(accepted[:HEADER_CHARS])):
        if wanted in LANGUAGES:
            return wanted
    return FALLBACK


def _by_preference(header: str) -> list[str]:
    weighed: list[tuple[float, str]] = []
    for part in header.split(","):
        tag, _, parameter = part.strip().partition(";")
        name, _, value = parameter.strip().partition("=")
        try:
            weight = float(value) if name.strip().lower() == "q" else 1.0
        except ValueError:
            weight = 0.0
        if 0 < weight <= 1:
            weighed.append((-weight, tag.strip().lower().partition("-")[0]))
    # Stable: of equals, the first one.
    return [language for _, language in sorted(weighed, key=lambda pair: pair[0])]
