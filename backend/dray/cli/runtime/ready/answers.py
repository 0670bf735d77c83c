"""A running gateway's answers about its plant, within the asker's permissions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar
from urllib.parse import quote

import msgspec

from dray.errors import SettingsError

T = TypeVar("T")

PAGE = 500
"""People or keys per request: the maximum of one answer."""

PEOPLE, DUTY = "people:write", "vehicles:command"
"""Scopes that are needed to see people and keys, and people on duty."""


class Client(Protocol):
    """Asks a gateway; `dray.cli.runtime.rest_client.RestClient` does."""

    def ask(self, method: str, path: str, shape: type[T]) -> T:
        """Send one request.

        Raises:
            SettingsError: the gateway does not know the asker, or refuses.
            UnavailableError: nobody answers there, or another server.
        """
        ...

    def date_s(self) -> float | None:
        """The wall clock of the gateway, in whole seconds, up to a second old; None without a date."""
        ...


class Part(msgspec.Struct, frozen=True):
    """The state of a part of the gateway."""

    ok: bool
    reason: str = ""


class Ready(msgspec.Struct, frozen=True):
    """The parts of a gateway that accepts orders."""

    parts: dict[str, Part]


class Me(msgspec.Struct, frozen=True):
    """The asker."""

    scopes: tuple[str, ...]
    areas: tuple[str, ...] | None = None


class Silence(msgspec.Struct, frozen=True):
    """The rule for counting an agent as failed."""

    lost_after_s: float


class Clock(msgspec.Struct, frozen=True):
    """An agent's clock error."""

    ahead_s: float
    wrong: bool


class Agent(msgspec.Struct, frozen=True, kw_only=True):
    """A machine, a vehicle or a station, by its last heartbeat; missing fields have the defaults below."""

    id: str
    seen_at_s: float
    silence: Silence
    status: str = ""
    problem: str = ""
    shut_out: dict[str, Any] | None = None
    out_of_service: dict[str, Any] | None = None
    removal: dict[str, Any] | None = None
    clock: Clock | None = None
    unconfirmed: tuple[dict[str, Any], ...] | None = None
    """Not None where people operate a machine."""


class Alert(msgspec.Struct, frozen=True):
    """A present problem."""

    kind: str
    agent: str = ""
    agents: tuple[str, ...] = ()


class Factory(msgspec.Struct, frozen=True):
    """The plant as a whole."""

    speed: float = 1.0


class Picture(msgspec.Struct, frozen=True, kw_only=True):
    """The plant as panels show it now."""

    at_s: float
    plant: str
    factory: Factory = Factory()
    machines: tuple[Agent, ...] = ()
    atvs: tuple[Agent, ...] = ()
    stations: tuple[Agent, ...] = ()
    """The stations of storages and warehouses, and the gate."""
    alerts: tuple[Alert, ...] = ()
    fault_injection: bool = False
    """Whether the plant is simulated."""

    def agents(self) -> dict[str, Agent]:
        """All agents heard, by id."""
        return {each.id: each for each in (*self.machines, *self.atvs, *self.stations)}


class Person(msgspec.Struct, frozen=True):
    """A person with a login, possibly disabled."""

    id: str
    role: str
    areas: tuple[str, ...] = ()
    secrets: tuple[str, ...] = ()
    disabled_at_s: float | None = None


class Key(msgspec.Struct, frozen=True):
    """A key of another system."""

    id: str
    name: str
    scopes: tuple[str, ...] = ()
    expires_at_s: float | None = None
    revoked_at_s: float | None = None


class Duty(msgspec.Struct, frozen=True):
    """The areas without an operator on duty."""

    areas_without: tuple[str, ...] = ()
    comes_at_s: dict[str, float] = {}
    """For areas outside their working hours, the time at which an operator comes."""


class _People(msgspec.Struct, frozen=True):
    items: tuple[Person, ...]
    next_cursor: str | None = None


class _Keys(msgspec.Struct, frozen=True):
    items: tuple[Key, ...]
    next_cursor: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Answers:
    """A gateway's answers.

    Attributes:
        parts: its parts, by name.
        picture: the plant as panels show it.
        plant: its plant file, as JSON.
        people: people with logins; None without permission.
        keys: keys of other systems; None without permission.
        duty: people on duty; None without permission.
        clock: unix times: of our request, of the gateway's date, of its answer; None without a date.
    """

    parts: dict[str, Part]
    picture: Picture
    plant: dict[str, Any]
    people: tuple[Person, ...] | None = None
    keys: tuple[Key, ...] | None = None
    duty: Duty | None = None
    clock: tuple[float, float, float] | None = None


def ask(client: Client, wall_s: Callable[[], float]) -> Answers:
    """Ask a gateway for everything.

    Args:
        client: sends the requests.
        wall_s: this computer's wall clock.

    Raises:
        SettingsError: the gateway does not know the asker, or the asker may not see the whole plant.
        UnavailableError: nobody answers there, or the gateway cannot accept orders.
    """
    parts = client.ask("GET", "/readyz", Ready).parts
    me = client.ask("GET", "/api/me", Me)
    if me.areas is not None or "factory:read" not in me.scopes:
        reason = (
            "it is of somebody who does not see the whole plant; take the administrator's, or a manager's key"
        )
        raise SettingsError("--token", reason)
    asked_s = wall_s()
    told_s = client.date_s()
    answered_s = wall_s()
    may_people = PEOPLE in me.scopes
    return Answers(
        parts=parts,
        picture=client.ask("GET", "/api/replay", Picture),
        plant=client.ask("GET", "/api/plant", dict),
        people=_all(client, "/api/people", _People) if may_people else None,
        keys=_all(client, "/api/keys", _Keys) if may_people else None,
        duty=client.ask("GET", "/api/duty", Duty) if DUTY in me.scopes else None,
        clock=None if told_s is None else (asked_s, told_s, answered_s),
    )


def _all(client: Client, path: str, shape: type[Any]) -> tuple[Any, ...]:
    found: tuple[Any, ...] = ()
    cursor: str | None = ""
    while cursor is not None:
        after = f"&cursor={quote(cursor, safe='')}" if cursor else ""
        page = client.ask("GET", f"{path}?limit={PAGE}{after}", shape)
        found += page.items
        cursor = page.next_cursor
    return found
