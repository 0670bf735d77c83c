"""Vehicles' states from a running gateway, as lines for a terminal."""

from __future__ import annotations

from urllib.parse import quote

import msgspec

from dray.cli.runtime.rest_client import RestClient

PAGE = 100
"""Vehicles per request."""


class Wait(msgspec.Struct, frozen=True):
    """The wait of a vehicle's body."""

    what: str
    since_at_s: float
    until: str = ""


class Vehicle(msgspec.Struct, frozen=True):
    """The displayed fields of one vehicle."""

    id: str
    status: str
    node: str
    battery_frac: float
    seen_at_s: float
    battery_reckoned: bool = False
    load: str = ""
    load_quantity: int = 0
    problem: str = ""
    body_wait: Wait | None = None


class Page(msgspec.Struct, frozen=True):
    """A page of vehicles."""

    items: tuple[Vehicle, ...]
    next_cursor: str | None = None


def ask(atv: str, url: str | None, token: str | None, now_s: float) -> list[list[str]]:
    """Lines about one vehicle, or about each that was heard.

    Args:
        atv: its id; empty for all.
        url: the address of the gateway's panel; None for the default of `dray up`.
        token: the caller's; None for the administrator's of the environment.
        now_s: unix time.

    Raises:
        InputError: there is no such vehicle.
        UnavailableError: no gateway answers there.
        SettingsError: the address or the token is invalid.
    """
    client = RestClient(url, token, "see GET /api/atvs")
    if atv:
        return [lines_of(client.ask("GET", f"/api/atvs/{quote(atv, safe='')}", Vehicle), now_s)]
    found: list[list[str]] = []
    cursor: str | None = ""
    while cursor is not None:
        after = f"&cursor={quote(cursor, safe='')}" if cursor else ""
        page = client.ask("GET", f"/api/atvs?limit={PAGE}{after}", Page)
        found += (lines_of(vehicle, now_s) for vehicle in page.items)
        cursor = page.next_cursor
    return found


def lines_of(vehicle: Vehicle, now_s: float) -> list[str]:
    """One vehicle; the last line tells what its body waits for, since when, and what would end the wait."""
    load = f"{vehicle.load_quantity} x {vehicle.load}" if vehicle.load else "nothing on board"
    about = "about " if vehicle.battery_reckoned else ""
    level = f"battery {about}{100 * vehicle.battery_frac:.0f} %"
    heard = f"heard {max(0.0, now_s - vehicle.seen_at_s):.0f} s ago"
    lines = [f"{vehicle.id}: {vehicle.status} at {vehicle.node}, {level}, {load}; {heard}"]
    if vehicle.problem:
        lines.append(f"    problem: {vehicle.problem}")
    wait = vehicle.body_wait
    if wait is None:
        return [*lines, "    waits for nothing that it tells"]
    until = f" (until {wait.until})" if wait.until else ""
    return [*lines, f"    waits for {max(0.0, now_s - wait.since_at_s):.0f} s: {wait.what}{until}"]
