"""Principals: whoever has been recognised, be it a person, another system's key or the administrator."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Literal

from dray.priorities import Priority


class Role(StrEnum):
    """What a person is here for."""

    MANAGER = "manager"
    OPERATOR = "operator"


class Scope(StrEnum):
    """One thing that somebody may be allowed."""

    FACTORY_READ = "factory:read"
    ORDERS_READ = "orders:read"
    ORDERS_WRITE = "orders:write"
    VEHICLES_COMMAND = "vehicles:command"
    VEHICLES_STOP = "vehicles:stop"
    """Stop, and nothing else; whoever may command vehicles may stop them."""
    TRANSPORTS_CALL = "transports:call"
    """Have something brought or taken away, see how far that is, and call it off. Whoever may do nothing else sees what it has asked for
    itself: a call button."""
    ALERTS_ACKNOWLEDGE = "alerts:acknowledge"
    AGENTS_WRITE = "agents:write"
    """Shut agents out, and readmit them."""
    FLOOR_WRITE = "floor:write"
    """Close lanes, places and areas to vehicles, and open them."""
    AUDIT_READ = "audit:read"
    PEOPLE_WRITE = "people:write"
    FAULTS_WRITE = "faults:write"


EVERYTHING = frozenset(Scope)

STOP_ONLY = frozenset({Scope.VEHICLES_STOP})

SCOPES: dict[Role, frozenset[Scope]] = {
    Role.MANAGER: EVERYTHING,
    Role.OPERATOR: frozenset(
        {
            Scope.FACTORY_READ,
            Scope.VEHICLES_COMMAND,
            Scope.VEHICLES_STOP,
            Scope.TRANSPORTS_CALL,
            Scope.ALERTS_ACKNOWLEDGE,
        }
    ),
}
"""What each role may; an operator in the areas of its own only."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CallLimits:
    """Which transports a key may call for.

    Attributes:
        places: machines and storages, one of which must be one end of each; empty for all of the plant.
        items: materials; empty for all.
        open_max: how many may be open at once.
        open_each_max: how many of them at one place.
        priority: the highest. Unless it is urgent, no transport is due sooner than such a one.
    """

    places: frozenset[str]
    items: frozenset[str]
    open_max: int
    open_each_max: int
    priority: Priority


class Over(StrEnum):
    """Why a session is good for a stop and for nothing else any more."""

    RUN_OUT = "run_out"
    """Its time is over."""
    REPLACED = "replaced"
    """Its person has logged in elsewhere."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Principal:
    """Somebody who has been recognised.

    Attributes:
        kind: how it was recognised: by a session, a key or the administrator's token; or that it is a schedule, which nobody recognises.
        id: of the person or key, unique in its kind; what the audit log names.
        name: what people call it.
        role: of a person; None for others.
        scopes: what it may do.
        areas: where it may do so; None for the whole plant.
        station: the machine at which an operator works; of a key, the place for which alone it calls for transports, where that is one.
            Empty where that matters nothing.
        calls: of a key, which transports it may call for; None for whatever there is.
        session: the session's id, which is no secret; empty where there is none.
        expires_at_s: when it will have to be recognised anew, in wall clock seconds; None for never.
        over: why its session is over, where it is; what it may still do is left in `scopes`.
    """

    kind: Literal["person", "key", "admin", "schedule"]
    id: str
    name: str
    role: Role | None = None
    scopes: frozenset[Scope]
    areas: frozenset[str] | None = None
    station: str = ""
    calls: CallLimits | None = None
    session: str = ""
    expires_at_s: float | None = None
    over: Over | None = None

    @property
    def key(self) -> str:
        """Its kind and id: whose a transport, a share or a stream is."""
        return f"{self.kind} {self.id}"

    def may(self, scope: Scope) -> bool:
        """Whether it is allowed this, if only in some areas."""
        return scope in self.scopes or (
            scope is Scope.VEHICLES_STOP and Scope.VEHICLES_COMMAND in self.scopes
        )


ADMIN = Principal(kind="admin", id="admin", name="Administrator", scopes=EVERYTHING)
"""Whoever has the administrator's token (`DRAY_ADMIN_TOKEN`)."""
