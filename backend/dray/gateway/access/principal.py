"""Principals: recognised callers, such as a person, another system's key or the administrator."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import Literal

from dray.priorities import Priority


class Role(StrEnum):
    """A person's role."""

    MANAGER = "manager"
    OPERATOR = "operator"


class Scope(StrEnum):
    """A right that a caller may have."""

    FACTORY_READ = "factory:read"
    ORDERS_READ = "orders:read"
    ORDERS_WRITE = "orders:write"
    VEHICLES_COMMAND = "vehicles:command"
    VEHICLES_STOP = "vehicles:stop"
    """Stop, and nothing else; included in the right to command vehicles."""
    TRANSPORTS_CALL = "transports:call"
    """Call for transports, see their progress, and cancel them. A caller with no other right sees only its
    own: a call button."""
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
"""Scopes of each role; an operator has them in its own areas only."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CallLimits:
    """Limits of the transports that a key may call for.

    Attributes:
        places: machines and storages, one of which must be an end of each transport; empty for all.
        items: materials; empty for all.
        open_max: maximum open transports.
        open_each_max: maximum open transports per place.
        priority: highest priority. Unless it is urgent, no transport is due sooner than one of this priority.
    """

    places: frozenset[str]
    items: frozenset[str]
    open_max: int
    open_each_max: int
    priority: Priority


class Over(StrEnum):
    """Why a session is valid for stops only."""

    RUN_OUT = "run_out"
    """It has expired."""
    REPLACED = "replaced"
    """Its person has logged in elsewhere."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Principal:
    """A recognised caller.

    Attributes:
        kind: how it was recognised: by session, key or administrator's token; or a schedule, which needs no
            recognition.
        id: id of the person or key, unique in its kind; named in the audit log.
        name: name for people.
        role: role of a person; None for others.
        scopes: its rights.
        areas: areas to which it is limited; None for the whole plant.
        station: an operator's machine; or a key's only place for transports, if it has one. Else empty.
        calls: a key's limits for transports; None for no limits.
        session: the session's id, which is no secret; empty without one.
        expires_at_s: when it must be recognised anew, in wall clock seconds; None for never.
        over: why its session is over, if so; `scopes` then has what remains.
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
        """Kind and id: the owner of a transport, a share or a stream."""
        return f"{self.kind} {self.id}"

    def may(self, scope: Scope) -> bool:
        """Whether it has this right, at least in some areas."""
        return scope in self.scopes or (
            scope is Scope.VEHICLES_STOP and Scope.VEHICLES_COMMAND in self.scopes
        )


ADMIN = Principal(kind="admin", id="admin", name="Administrator", scopes=EVERYTHING)
"""The holder of the administrator's token (`DRAY_ADMIN_TOKEN`)."""
