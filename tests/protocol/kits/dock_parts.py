"""The parts of one dock without its agent, for tests."""

from __future__ import annotations

from dray.messages.keys import Keys
from dray.protocol.liveness.failure_detector import HeartbeatSubscriptions
from dray.protocol.runtime.life import Life
from dray.protocol.transports.bookings import Bookings
from dray.protocol.transports.dock_door import Door
from dray.protocol.transports.visits import Visits


def dock_parts(node: str, subscriptions: HeartbeatSubscriptions, life: Life) -> tuple[Door, Visits]:
    """The door of a dock whose body may take a minute, and the visits."""
    visits = Visits(node, subscriptions, Bookings(life), life)
    return Door(visits, 60.0, life), visits


def blind_dock(node: str, life: Life) -> tuple[Door, Visits]:
    """The same, where the body does not count."""
    door, visits = dock_parts(node, HeartbeatSubscriptions(Keys("dray").atv_heartbeat, life), life)
    visits.counts = False
    return door, visits
