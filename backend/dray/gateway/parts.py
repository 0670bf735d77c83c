"""What routers need: the parts of one running gateway, and how a request gets at them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, cast

from fastapi import Depends
from starlette.requests import HTTPConnection

from dray.gateway.access.access import Access
from dray.gateway.alertdesk import AlertDesk
from dray.gateway.commands import Commands
from dray.gateway.desk import Desk
from dray.gateway.endings import Endings
from dray.gateway.exclusiondesk import ExclusionDesk
from dray.gateway.faultdesk import FaultDesk
from dray.gateway.health import Health
from dray.gateway.ledger import Ledger
from dray.gateway.metrics.metrics import Metrics
from dray.gateway.panels import Panels
from dray.gateway.peer import Peer
from dray.gateway.presence import Presence
from dray.gateway.projection import Projection
from dray.gateway.sidework import SideWork
from dray.gateway.stream import Hub
from dray.plant import Plant
from dray.plant.model import PlantFile
from dray.settings import Settings
from dray.store import Historian, Store
from dray.store.placing import Placing


@dataclass
class Intake:
    """What the intake of orders works with.

    Attributes:
        placing: writes them.
        coming: how many are being written at this moment.
    """

    placing: Placing
    coming: int = 0


@dataclass(frozen=True)
class Parts:
    """One running gateway."""

    settings: Settings
    store: Store
    historian: Historian | None
    """None where it runs elsewhere."""
    wall_s: Callable[[], float]
    access: Access
    projection: Projection
    desk: Desk
    endings: Endings
    commands: Commands
    alerts: AlertDesk
    exclusions: ExclusionDesk
    ledger: Ledger
    hub: Hub
    peer: Peer
    presence: Presence
    health: Health
    metrics: Metrics
    panels: Panels
    faults: FaultDesk | None
    """None where the factory is not simulated."""
    side_work: SideWork
    keys_at_work: set[str]
    """Idempotency keys of requests that are being answered at this moment."""
    intake: Intake

    @property
    def plant(self) -> PlantFile:
        """What stands where at this moment."""
        return self.floor.file

    @property
    def floor(self) -> Plant:
        """The same, for whoever asks where something is."""
        return self.projection.site.plant


def parts_of(connection: HTTPConnection) -> Parts:
    """The gateway that this request came to."""
    return cast(Parts, connection.app.state.parts)


async def _parts(connection: HTTPConnection) -> Parts:
    return parts_of(connection)


Gateway = Annotated[Parts, Depends(_parts)]
"""A router's parameter."""
