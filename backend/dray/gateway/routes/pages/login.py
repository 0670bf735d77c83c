"""The login: pages that work without a script, one for managers and one for operators.

A page's form is answered with a page; a program that sends the same form gets problems as JSON.
"""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from http import HTTPStatus
from typing import Annotated, Any, Literal
from urllib.parse import urlencode

from fastapi import APIRouter, Query, Request
from fastapi.responses import RedirectResponse, Response
from fastapi.routing import APIRoute

from dray.errors import UnavailableError
from dray.gateway.access.access import Access
from dray.gateway.access.audit_log import Noted
from dray.gateway.access.audit_recorder import address_of
from dray.gateway.access.caller import Caller
from dray.gateway.access.gate import COOKIE, wants_page
from dray.gateway.access.login import cookies
from dray.gateway.access.login.login import LinkUsedUp, WrongLogin
from dray.gateway.access.login.page import login_form, page, refused
from dray.gateway.access.login.redirect import redirect_target
from dray.gateway.access.login.stations import stations_in
from dray.gateway.access.principal import Role
from dray.gateway.access.sessions import principal_of
from dray.gateway.http.assets import Panels
from dray.gateway.http.problems import FieldError, Problem, away, unusable
from dray.gateway.http.provided import Provided, provided
from dray.gateway.http.request_bodies import read_form
from dray.gateway.live.projection import Projection
from dray.plant.model import PlantFile
from dray.store.access.people import Person


class _Page(APIRoute):
    """Shows a missing database to a person as a page."""

    def get_route_handler(self) -> Callable[[Request], Coroutine[Any, Any, Response]]:
        """See `fastapi.routing.APIRoute`."""
        handle = super().get_route_handler()

        async def answer(request: Request) -> Response:
            try:
                return await handle(request)
            except UnavailableError:
                wanted = request.query_params.get("next", "")
                return refused(provided(request.app, Panels), request, away(), {"next": wanted})

        return answer


router = APIRouter(include_in_schema=False, route_class=_Page)

FIELDS = 10
"""Maximum fields in a form: the login's has six."""

Next = Annotated[str, Query(alias="next", max_length=2000)]
As = Annotated[Literal["", "manager", "operator"], Query(alias="as")]


@router.get("/login")
async def login_page(
    access: Provided[Access], panels: Provided[Panels], request: Request, wanted: Next = "", role: As = ""
) -> Response:
    """The login form."""
    caller = await access.sessions.recognise(request.cookies.get(COOKIE, ""))
    if caller is not None and caller.role is not None and not caller.over:
        return _go(redirect_target(wanted, caller.role))
    return login_form(panels, request, HTTPStatus.OK, {"next": wanted, "as": role})


@router.post("/login")
async def log_in(
    access: Provided[Access],
    projection: Provided[Projection],
    panels: Provided[Panels],
    request: Request,
    note: Noted,
) -> Response:
    """Log a person in by name and password or PIN, or by badge."""
    form = await read_form(request, FIELDS)
    login, address = access.login, address_of(request.scope)
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
        return refused(panels, request, wrong, form)
    except Problem as problem:
        return refused(panels, request, problem, form)
    return await _welcome(access, projection.site.plant.file, request, note, person, form.get("next", ""))


@router.get("/login/station")
async def station_page(
    projection: Provided[Projection],
    panels: Provided[Panels],
    request: Request,
    caller: Caller,
    wanted: Next = "",
) -> Response:
    """The form for an operator's station."""
    stations = stations_in(projection.site.plant.file, caller.areas or ())
    return page(
        panels,
        request,
        HTTPStatus.OK,
        "login-station.html",
        stations=stations,
        station=caller.station or request.cookies.get(cookies.STATION, ""),
        next=wanted,
        carried=[("next", wanted)],
    )


@router.post("/login/station")
async def take_station(
    access: Provided[Access], projection: Provided[Projection], request: Request, caller: Caller, note: Noted
) -> Response:
    """Set the operator's station."""
    form = await read_form(request, FIELDS)
    station = note.target = form.get("station", "")
    if station not in {machine.id for machine in stations_in(projection.site.plant.file, caller.areas or ())}:
        raise unusable(FieldError("station", "it is no machine in your areas"))
    await access.sessions.place(caller.session, station)
    answer = _go(redirect_target(form.get("next", ""), Role.OPERATOR))
    cookies.remember_station(answer, request, station)
    return answer


@router.get("/login/{token}")
async def link_page(
    access: Provided[Access], panels: Provided[Panels], request: Request, token: str
) -> Response:
    """The person whom a link logs in. Viewing does not use it up, because programs preview links."""
    try:
        person = await access.login.whose_link(token)
    except LinkUsedUp as used:
        return refused(panels, request, used, {})
    return page(panels, request, HTTPStatus.OK, "login-link.html", person=person)


@router.post("/login/{token}")
async def use_link(
    access: Provided[Access],
    projection: Provided[Projection],
    panels: Provided[Panels],
    request: Request,
    note: Noted,
    token: str,
) -> Response:
    """Log a person in by a link, once."""
    note.target, note.detail["by"] = "", "link"
    try:
        person = await access.login.by_link(token, address_of(request.scope))
    except LinkUsedUp as used:
        note.result = "refused"
        return refused(panels, request, used, {})
    except Problem as problem:
        return refused(panels, request, problem, {})
    return await _welcome(access, projection.site.plant.file, request, note, person, "")


@router.post("/logout")
async def log_out(access: Provided[Access], request: Request, note: Noted) -> Response:
    """End this browser's session; harmless when done twice."""
    ended = await access.sessions.end(request.cookies.get(COOKIE, ""))
    if ended is not None:
        note.who = principal_of(*ended)
        await access.watch.soon()
    answer = _go("/login") if wants_page(request.scope) else Response(status_code=HTTPStatus.NO_CONTENT)
    cookies.take_session(answer, request)
    return answer


async def _welcome(
    access: Access, plant: PlantFile, request: Request, note: Noted, person: Person, wanted: str
) -> Response:
    """Begin a session and redirect."""
    role = Role(person.role)
    station = _station(plant, request, person) if role is Role.OPERATOR else ""
    token, session = await access.sessions.begin(
        person, before=request.cookies.get(COOKIE, ""), station=station
    )
    await access.watch.soon()
    note.who = principal_of(person, session)
    if station:
        note.detail["station"] = station
    target = redirect_target(wanted, role)
    if role is Role.OPERATOR and not station and stations_in(plant, person.areas):
        target = f"/login/station?{urlencode({'next': target})}"
    answer = _go(target)
    cookies.give_session(answer, request, token, role)
    if role is Role.OPERATOR:
        cookies.remember_person(answer, request, person)
    return answer


def _station(plant: PlantFile, request: Request, person: Person) -> str:
    """This device's station, if it is in the operator's areas; else the only machine there."""
    stations = [machine.id for machine in stations_in(plant, person.areas)]
    here = request.cookies.get(cookies.STATION, "")
    if here in stations:
        return here
    return stations[0] if len(stations) == 1 else ""


def _go(path: str) -> Response:
    return RedirectResponse(path, HTTPStatus.SEE_OTHER, headers={"Cache-Control": "no-store"})
