"""The login's pages: forms in the visitor's language, and errors in words."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from http import HTTPStatus
from typing import Any
from urllib.parse import urlencode

from fastapi import Request
from fastapi.responses import HTMLResponse, PlainTextResponse, Response

from dray.gateway.access.gate import wants_page
from dray.gateway.access.login import cookies
from dray.gateway.access.login.login import LinkUsedUp
from dray.gateway.access.login.redirect import HOMES
from dray.gateway.access.login.texts import TEXTS
from dray.gateway.access.login.texts.catalogue import Catalogue
from dray.gateway.access.principal import Role
from dray.gateway.http.assets import NotBuilt, Panels
from dray.gateway.http.language import language_of, remember_language, switches
from dray.gateway.http.problems import AWAY, Problem

HEADERS = {
    "Cache-Control": "no-store",
    # Without any referrer, browsers hide the origin of a sent form, and the middleware against other sites'
    # pages would refuse it.
    "Referrer-Policy": "same-origin",
    "X-Robots-Tag": "noindex, nofollow",
}

NOT_BUILT = """\
The login page is not built. Run `make panels` in the checkout and load this page again.
Programs need no page: they send Authorization: Bearer TOKEN.
"""


def refused(panels: Panels, request: Request, problem: Problem, form: Mapping[str, str]) -> Response:
    """The failure as a page for a person, or as a problem for a program."""
    if not wants_page(request.scope):
        raise problem
    if isinstance(problem, LinkUsedUp):
        return page(panels, request, HTTPStatus(problem.status), "login-gone.html")
    return login_form(panels, request, HTTPStatus(problem.status), form, problem)


def login_form(
    panels: Panels,
    request: Request,
    status: HTTPStatus,
    form: Mapping[str, str],
    problem: Problem | None = None,
) -> Response:
    """The form as filled in, without the secret."""
    wanted = form.get("next", "")
    operator = form.get("as") == "operator" or (
        not form.get("as") and wanted.startswith(HOMES[Role.OPERATOR])
    )
    by_badge = operator and bool(form.get("badge"))
    texts = TEXTS[language_of(request)]
    wrong = texts.wrong_badge if by_badge else texts.wrong_pin if operator else texts.wrong_password
    return page(
        panels,
        request,
        status,
        "login.html",
        operator=operator,
        next=wanted,
        typed=form.get("name", ""),
        known=cookies.known_people(request) if operator else [],
        chosen=form.get("known", ""),
        wrong="" if problem is None else _words(problem, texts, wrong),
        by_badge=by_badge,
        headers={} if problem is None else problem.headers,
        carried=[("next", wanted), ("as", form.get("as", ""))],
        # A page of another site led here, so the browser has withheld our cookie. This page reloads the
        # address, and the cookie is sent.
        again=request.headers.get("sec-fetch-site") == "cross-site",
    )


def _words(problem: Problem, texts: Catalogue, wrong: str) -> str:
    match problem.status:
        case HTTPStatus.TOO_MANY_REQUESTS:
            wait_s = int(problem.headers["Retry-After"])
            wait = (
                texts.seconds.format(n=wait_s) if wait_s < 120 else texts.minutes.format(n=-(-wait_s // 60))
            )
            return texts.too_many.format(wait=wait)
        case HTTPStatus.SERVICE_UNAVAILABLE:
            return texts.away if problem.kind == AWAY else texts.busy
        case _:
            return wrong


def page(
    panels: Panels,
    request: Request,
    status: HTTPStatus,
    template: str,
    headers: Mapping[str, str] | None = None,
    carried: Iterable[tuple[str, str]] = (),
    **context: Any,
) -> Response:
    """A page in the visitor's language.

    Args:
        panels: the templates.
        request: the request to answer.
        status: status of the answer.
        template: name of the template.
        headers: additional headers.
        carried: parameters kept when only the language changes.
        context: values for the template.
    """
    language = language_of(request)
    try:
        html = panels.render(
            template,
            language=language,
            texts=TEXTS[language],
            switches=switches(language),
            carried=urlencode({name: value for name, value in carried if value}),
            **context,
        )
    except NotBuilt:
        return PlainTextResponse(NOT_BUILT, HTTPStatus.SERVICE_UNAVAILABLE, headers=HEADERS)
    answer = HTMLResponse(html, status, headers=HEADERS | dict(headers or {}))
    remember_language(answer, request)
    return answer
