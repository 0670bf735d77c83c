"""The parts of one dock without its agent, for tests."""

from __future__ import annotations

from dray.protocol.liveness.failure_detector import HeartbeatSubscriptions
from dray.protocol.runtime.life import Life
from dray.protocol.transports.booking_out import BookingOut
from dray.protocol.transports.bookings import Bookings
from dray.protocol.transports.departures import Departures
from dray.protocol.transports.dock_door import Door
from dray.protocol.transports.visits import Visits


def dock_parts(node: str, subscriptions: HeartbeatSubscriptions, life: Life) -> tuple[Door, Departures]:
    """The door of a dock whose body may take a minute, and the departures."""
    visits, bookings = Visits(), Bookings(life)
    departures = Departures(node, visits, subscriptions, bookings, life)
    booking_out = BookingOut(node, subscriptions, bookings, departures, life)
    return Door(visits, departures, booking_out, 60.0, life), departures
