"""What a running gateway says of its plant, as far as whoever asks may know it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar
from urllib.parse import quote

import msgspec

from dray.errors import SettingsError

T = TypeVar("T")

PAGE = 500
"""People or keys that are asked for at once: the most that a gateway tells in one answer."""

PEOPLE, DUTY = "people:write", "vehicles:command"
"""Scopes, without which nothing is told of people and keys, and of who is on duty."""


class Client(Protocol):
    """Asks a gateway; `dray.cli.runtime.rest_client.RestClient` does."""

    def ask(self, method: str, path: str, shape: type[T]) -> T:
        """One request.

        Raises:
            SettingsError: the gateway does not know who asks, or refuses.
            UnavailableError: nobody answers there, or not as Dray does.
        """
        ...

    def date_s(self) -> float | None:
        """The wall clock of the gateway, in whole seconds, up to a second old; None where it does not tell."""
        ...


class Part(msgspec.Struct, frozen=True):
    """How a part of the gateway is."""

    ok: bool
    reason: str = ""


class Ready(msgspec.Struct, frozen=True):
    """The parts of a gateway that takes orders."""

    parts: dict[str, Part]


class Me(msgspec.Struct, frozen=True):
    """Who asks."""

    scopes: tuple[str, ...]
    areas: tuple[str, ...] | None = None


class Silence(msgspec.Struct, frozen=True):
    """The rule by which an agent counts as failed."""

    lost_after_s: float


class Clock(msgspec.Struct, frozen=True):
    """How far an agent's clock is off."""

    ahead_s: float
    wrong: bool


class Agent(msgspec.Struct, frozen=True, kw_only=True):
    """A machine, a vehicle or a station, as its last heartbeat told; fields that its kind does not have are as below."""

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
    """Not None where the body of a machine is people."""


class Alert(msgspec.Struct, frozen=True):
    """Something that is wrong now."""

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
    """Those of storages and warehouses, and the gate."""
    alerts: tuple[Alert, ...] = ()
    fault_injection: bool = False
    """The plant is simulated."""

    def agents(self) -> dict[str, Agent]:
        """All that were heard, by id."""
        return {each.id: each for each in (*self.machines, *self.atvs, *self.stations)}


class Person(msgspec.Struct, frozen=True):
    """Somebody who may log in, or no more."""

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
    """In which areas nobody is on duty."""

    areas_without: tuple[str, ...] = ()
    comes_at_s: dict[str, float] = {}
    """Of these, where nobody is there by the working time: when somebody comes."""


class _People(msgspec.Struct, frozen=True):
    items: tuple[Person, ...]
    next_cursor: str | None = None


class _Keys(msgspec.Struct, frozen=True):
    items: tuple[Key, ...]
    next_cursor: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Answers:
    """What a gateway has said.

    Attributes:
        parts: its parts, by name.
        picture: the plant as panels show it.
        plant: its plant file, as JSON.
        people: who may log in; None where whoever asks may not know that.
        keys: those of other systems; None likewise.
        duty: who is on duty; None likewise.
        clock: unix times: when its clock was asked by ours, what it said, and when that came; None where it does not tell.
    """

    parts: dict[str, Part]
    picture: Picture
    plant: dict[str, Any]
    people: tuple[Person, ...] | None = None
    keys: tuple[Key, ...] | None = None
    duty: Duty | None = None
    clock: tuple[float, float, float] | None = None


def ask(client: Client, wall_s: Callable[[], float]) -> Answers:
    """Ask a gateway everything.

    Args:
        client: asks it.
        wall_s: this computer's wall clock.

    Raises:
        SettingsError: the gateway does not know who asks, or whoever asks may not see the whole plant.
        UnavailableError: nobody answers there, or it cannot take orders.
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
