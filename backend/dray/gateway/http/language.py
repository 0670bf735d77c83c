"""The language of a page: from its address, else the last choice, else the browser's preference.

The panels' scripts use the same cookie, so it is readable for them; it holds no secret.
"""

from __future__ import annotations

from collections.abc import Mapping

import msgspec
from starlette.requests import Request
from starlette.responses import Response

LANGUAGES: Mapping[str, str] = {"en": "English", "de": "Deutsch", "es": "Español"}
"""Languages of the pages, each by its own name."""

FALLBACK = "en"

HEADER_CHARS = 500
"""Maximum characters of an Accept-Language header: more than any browser sends."""

COOKIE = "dray_language"

REMEMBERED_S = 365 * 86_400
"""Seconds for which a browser remembers the chosen language."""


class Switch(msgspec.Struct, frozen=True):
    """A language choice."""

    code: str
    name: str
    chosen: bool


def switches(language: str) -> tuple[Switch, ...]:
    """All languages, with the chosen one marked."""
    return tuple(Switch(code, name, code == language) for code, name in LANGUAGES.items())


def language_of(request: Request) -> str:
    """The language of the answer to this request."""
    return choose(
        request.query_params.get("lang", ""),
        request.cookies.get(COOKIE, ""),
        request.headers.get("accept-language", ""),
    )


def remember_language(answer: Response, request: Request) -> None:
    """Remember the language in the request's address, if any."""
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
        chosen: from the address; empty if none.
        remembered: from the cookie; empty if none.
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
    # A stable sort: of equals, the first one wins.
    return [language for _, language in sorted(weighed, key=lambda pair: pair[0])]
