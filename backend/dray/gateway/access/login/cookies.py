"""Cookies of the login: the session, and a device's memory for its next login."""

from __future__ import annotations

from typing import Literal

from starlette.requests import Request
from starlette.responses import Response

from dray.gateway.access.gate import COOKIE
from dray.gateway.access.principal import Role
from dray.gateway.access.sessions import LIFE_S, MAY_STILL_STOP_S
from dray.store.access.people import Person

STATION = "dray_station"
"""The machine at which this device stands: a tablet at a station asks only once."""

PEOPLE = "dray_people"
"""Operators who have logged in on this device, so that nobody types a name with gloves on."""

PEOPLE_KEPT = 6
"""Maximum operators remembered: three shifts of two, as many buttons as fit on a tablet."""

REMEMBERED_S = 365 * 86_400


def give_session(answer: Response, request: Request, token: str, role: Role) -> None:
    """Log this browser in.

    The cookie lives as long as the session can be of use; only the server judges its validity.
    """
    life_s = LIFE_S[role] + (MAY_STILL_STOP_S if role is Role.OPERATOR else 0.0)
    _set(answer, request, COOKIE, token, int(life_s), "strict")


def take_session(answer: Response, request: Request) -> None:
    """Log this browser out."""
    answer.delete_cookie(COOKIE, path="/", secure=_secure(request), httponly=True, samesite="strict")


def remember_person(answer: Response, request: Request, person: Person) -> None:
    """Remember an operator on this device."""
    known = [person.id, *(each for each in known_people(request) if each != person.id)]
    _set(answer, request, PEOPLE, " ".join(known[:PEOPLE_KEPT]), REMEMBERED_S, "lax")


def known_people(request: Request) -> list[str]:
    """Operators known to this device, the last one first."""
    return request.cookies.get(PEOPLE, "").split()[:PEOPLE_KEPT]


def remember_station(answer: Response, request: Request, station: str) -> None:
    """Remember the station of this device."""
    _set(answer, request, STATION, station, REMEMBERED_S, "lax")


def _set(
    answer: Response, request: Request, name: str, value: str, life_s: int, site: Literal["lax", "strict"]
) -> None:
    answer.set_cookie(
        name,
        value,
        max_age=life_s,
        path="/",
        secure=_secure(request),
        httponly=True,
        samesite=site,
    )


def _secure(request: Request) -> bool:
    return request.url.scheme == "https"
