"""Cookies of the login: the session's, and what a device remembers for the next login at it."""

from __future__ import annotations

from typing import Literal

from starlette.requests import Request
from starlette.responses import Response

from dray.gateway.access.gate import COOKIE
from dray.gateway.access.principal import Role
from dray.gateway.access.sessions import LIFE_S, MAY_STILL_STOP_S
from dray.store.access.people import Person

STATION = "dray_station"
"""The machine at which this device stands: a tablet at a station is asked for it once."""

PEOPLE = "dray_people"
"""Operators who have logged in on this device: nobody types a name with gloves on."""

PEOPLE_KEPT = 6
"""Three shifts of two: as many buttons as fit on a tablet."""

REMEMBERED_S = 365 * 86_400


def give_session(answer: Response, request: Request, token: str, role: Role) -> None:
    """Log this browser in.

    The cookie lives as long as the session may still be good for something; what it is worth is judged by
    the server alone.
    """
    life_s = LIFE_S[role] + (MAY_STILL_STOP_S if role is Role.OPERATOR else 0.0)
    _set(answer, request, COOKIE, token, int(life_s), "strict")


def take_session(answer: Response, request: Request) -> None:
    """Log this browser out."""
    answer.delete_cookie(COOKIE, path="/", secure=_secure(request), httponly=True, samesite="strict")


def remember_person(answer: Response, request: Request, person: Person) -> None:
    """Let this device know an operator again."""
    known = [person.id, *(each for each in known_people(request) if each != person.id)]
    _set(answer, request, PEOPLE, " ".join(known[:PEOPLE_KEPT]), REMEMBERED_S, "lax")


def known_people(request: Request) -> list[str]:
    """Operators whom this device knows, the last one first."""
    return request.cookies.get(PEOPLE, "").split()[:PEOPLE_KEPT]


def remember_station(answer: Response, request: Request, station: str) -> None:
    """Let this device know where it stands."""
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
