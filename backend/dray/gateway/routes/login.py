"""The login: pages that work without a script, one for managers and one for operators.

A form of a page is answered with a page; a program that sends the same form gets problems as JSON.
"""

from __future__ import annotations

from collections.abc import Callable, Coroutine, Iterable, Mapping
from http import HTTPStatus
from typing import Annotated, Any, Literal
from urllib.parse import urlencode

from fastapi import APIRouter, Query, Request
from fastapi.responses import HTMLResponse, PlainTextResponse, RedirectResponse, Response
from fastapi.routing import APIRoute

from dray.errors import UnavailableError
from dray.gateway.access import cookies
from dray.gateway.access.caller import Caller
from dray.gateway.access.gate import COOKIE, wants_page
from dray.gateway.access.login import LinkUsedUp, WrongLogin
from dray.gateway.access.onward import HOMES, onward
from dray.gateway.access.principal import Role
from dray.gateway.access.recorder import address_of
from dray.gateway.access.sessions import principal_of
from dray.gateway.access.stations import stations_in
from dray.gateway.access.texts import TEXTS
from dray.gateway.access.trail import Noted
from dray.gateway.language import language_of, remember_language
from dray.gateway.panels import NotBuilt
from dray.gateway.parts import Gateway, Parts, parts_of
from dray.gateway.problems import AWAY, FieldError, Problem, away, unusable
from dray.gateway.tracking.page import switches
from dray.store.people import Person


class _Page(APIRoute):
    """Tells a person that the database is away as a page, too."""

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """See `fastapi.routing.APIRoute`."""
        handle = super().get_route_handler()

        async def answer(request: Request) -> Response:
            try:
                return await handle(request)
            except UnavailableError as error:
                wanted = request.query_params.get("next", "")
                return _refused(parts_of(request), request, away(request, error), {"next": wanted})

        return answer


router = APIRouter(include_in_schema=False, route_class=_Page)

FORM = "application/x-www-form-urlencoded"

FIELDS = 10
"""In a form: the login's has six."""

HEADERS = {
    "Cache-Control": "no-store",
    # With no referrer at all, browsers would hide the origin of a form that is sent, and the shield against
    # other sites' pages would refuse it.
    "Referrer-Policy": "same-origin",
    "X-Robots-Tag": "noindex, nofollow",
}

NOT_BUILT = """\
The login page is not built. Run `make panels` in the checkout and load this page again.
Programs need no page: they send Authorization: Bearer TOKEN.
"""

Next = Annotated[str, Query(alias="next", max_length=2000)]
As = Annotated[Literal["", "manager", "operator"], Query(alias="as")]


@router.get("/login")
async def login_page(gateway: Gateway, request: Request, wanted: Next = "", role: As = "") -> Response:
    """Who are you?"""
    caller = await gateway.access.sessions.recognise(request.cookies.get(COOKIE, ""))
    if caller is not None and caller.role is not None and not caller.over:
        return _go(onward(wanted, caller.role))
    return _login(gateway, request, HTTPStatus.OK, {"next": wanted, "as": role})


@router.post("/login")
async def log_in(gateway: Gateway, request: Request, note: Noted) -> Response:
    """Log somebody in by name and password or PIN, or by badge."""
    form = await _form(request)
    login, address = gateway.access.login, address_of(request.scope)
    note.detail["by"] = "badge" if form.get("badge") else "name"
    try:
        if form.get("badge"):
            person = await login.by_badge(form["badge"], address)
        else:
            person = await login.by_name(
                form.get("name") or form.get("known", ""), form.get("secret", ""), address
            )
    except WrongLogin as wrong:
        note.result, note.target = "refused", wrong.claimed
        return _refused(gateway, request, wrong, form)
    except Problem as problem:
        return _refused(gateway, request, problem, form)
    return await _welcome(gateway, request, note, person, form.get("next", ""))


@router.get("/login/station")
async def station_page(gateway: Gateway, request: Request, caller: Caller, wanted: Next = "") -> Response:
    """Where do you work?"""
    stations = stations_in(gateway.plant, caller.areas or ())
    return _page(
        gateway,
        request,
        HTTPStatus.OK,
        "login-station.html",
        stations=stations,
        station=caller.station or request.cookies.get(cookies.STATION, ""),
        next=wanted,
        carried=[("next", wanted)],
    )


@router.post("/login/station")
async def take_station(gateway: Gateway, request: Request, caller: Caller, note: Noted) -> Response:
    """Work at this machine from now on."""
    form = await _form(request)
    station = note.target = form.get("station", "")
    if station not in {machine.id for machine in stations_in(gateway.plant, caller.areas or ())}:
        raise unusable(FieldError("station", "it is no machine in your areas"))
    await gateway.access.sessions.place(caller.session, station)
    answer = _go(onward(form.get("next", ""), Role.OPERATOR))
    cookies.remember_station(answer, request, station)
    return answer


@router.get("/login/{token}")
async def link_page(gateway: Gateway, request: Request, token: str) -> Response:
    """Whom this link logs in. Looking uses nothing up: programs look at links before people do."""
    try:
        person = await gateway.access.login.whose_link(token)
    except LinkUsedUp as used:
        return _refused(gateway, request, used, {})
    return _page(gateway, request, HTTPStatus.OK, "login-link.html", person=person)


@router.post("/login/{token}")
async def use_link(gateway: Gateway, request: Request, note: Noted, token: str) -> Response:
    """Log somebody in by a link, once."""
    note.target, note.detail["by"] = "", "link"
    try:
        person = await gateway.access.login.by_link(token, address_of(request.scope))
    except LinkUsedUp as used:
        note.result = "refused"
        return _refused(gateway, request, used, {})
    except Problem as problem:
        return _refused(gateway, request, problem, {})
    return await _welcome(gateway, request, note, person, "")


@router.post("/logout")
async def log_out(gateway: Gateway, request: Request, note: Noted) -> Response:
    """End the session of this browser; done again, it does nothing."""
    ended = await gateway.access.sessions.end(request.cookies.get(COOKIE, ""))
    if ended is not None:
        note.who = principal_of(*ended)
        await gateway.access.watch.soon()
    page = wants_page(request.scope)
    answer = _go("/login") if page else Response(status_code=HTTPStatus.NO_CONTENT)
    cookies.take_session(answer, request)
    return answer


async def _form(request: Request) -> dict[str, str]:
    """The text fields of a form.

    Raises:
        Problem: 415, it is no form of ours.
    """
    kind = request.headers.get("content-type", "").partition(";")[0].strip().lower()
    if kind != FORM:
        raise Problem(
            HTTPStatus.UNSUPPORTED_MEDIA_TYPE,
            "not-called-form",
            "The body is not called a form",
            f"Content-Type is {kind[:64]!r}; send {FORM}",
        )
    form = await request.form(max_files=0, max_fields=FIELDS)
    return {name: value for name, value in form.items() if isinstance(value, str)}


async def _welcome(gateway: Parts, request: Request, note: Noted, person: Person, wanted: str) -> Response:
    """Begin a session, and go on."""
    role = Role(person.role)
    station = _station(gateway, request, person) if role is Role.OPERATOR else ""
    token, session = await gateway.access.sessions.begin(
        person, before=request.cookies.get(COOKIE, ""), station=station
    )
    await gateway.access.watch.soon()
    note.who = principal_of(person, session)
    if station:
        note.detail["station"] = station
    target = onward(wanted, role)
    if role is Role.OPERATOR and not station and stations_in(gateway.plant, person.areas):
        target = f"/login/station?{urlencode({'next': target})}"
    answer = _go(target)
    cookies.give_session(answer, request, token, role)
    if role is Role.OPERATOR:
        cookies.remember_person(answer, request, person)
    return answer


def _station(gateway: Parts, request: Request, person: Person) -> str:
    """Where this device stands, if that is in one of the operator's areas; else the only machine there."""
    stations = [machine.id for machine in stations_in(gateway.plant, person.areas)]
    here = request.cookies.get(cookies.STATION, "")
    if here in stations:
        return here
    return stations[0] if len(stations) == 1 else ""


def _go(path: str) -> Response:
    return RedirectResponse(path, HTTPStatus.SEE_OTHER, headers={"Cache-Control": "no-store"})


def _refused(gateway: Parts, request: Request, problem: Problem, form: Mapping[str, str]) -> Response:
    """What went wrong: for a person as a page, for a program as a problem."""
    if not wants_page(request.scope):
        raise problem
    if isinstance(problem, LinkUsedUp):
        return _page(gateway, request, HTTPStatus(problem.status), "login-gone.html")
    return _login(gateway, request, HTTPStatus(problem.status), form, problem)


def _login(
    gateway: Parts,
    request: Request,
    status: HTTPStatus,
    form: Mapping[str, str],
    problem: Problem | None = None,
) -> Response:
    """The form, as it was filled in, without the secret."""
    wanted = form.get("next", "")
    operator = form.get("as") == "operator" or (
        not form.get("as") and wanted.startswith(HOMES[Role.OPERATOR])
    )
    return _page(
        gateway,
        request,
        status,
        "login.html",
        operator=operator,
        next=wanted,
        typed=form.get("name", ""),
        known=cookies.known_people(request) if operator else [],
        chosen=form.get("known", ""),
        wrong="" if problem is None else _words(problem, language_of(request)),
        headers={} if problem is None else problem.headers,
        carried=[("next", wanted), ("as", form.get("as", ""))],
        # A page of another site led here, so the browser has kept our cookie to itself. Loaded again by
        # this page, the same address is asked for with it.
        again=request.headers.get("sec-fetch-site") == "cross-site",
    )


def _words(problem: Problem, language: str) -> str:
    texts = TEXTS[language]
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
            return texts.wrong


def _page(
    gateway: Parts,
    request: Request,
    status: HTTPStatus,
    template: str,
    headers: Mapping[str, str] | None = None,
    carried: Iterable[tuple[str, str]] = (),
    **context: Any,
) -> Response:
    """A page in the visitor's language.

    Args:
        gateway: ours.
        request: what is answered.
        status: of the answer.
        template: its name.
        headers: more of them.
        carried: what the address must keep when only the language changes.
        context: what the template shows.
    """
    language = language_of(request)
    try:
        html = gateway.panels.render(
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
