"""When a plain transport reached its stages: those of its last announcement, as the agents' facts tell them."""

from __future__ import annotations

from dray.gateway.orders.transport_timeline import KINDS, transport_timeline
from dray.gateway.tracking.transport import TransportSteps
from dray.messages import TransportState
from dray.store import Store
from dray.store.orders.transports import TransportRow

ATTEMPTS_MOST = 100
"""Maximum attempts read per transport: usually one, and one more per restart of its destination."""

EVENTS_MOST = 2_000
"""Maximum events read per transport: ten takeovers of each attempt have fewer."""

REACHED = (TransportState.ASSIGNED, TransportState.ON_BOARD, TransportState.DELIVERED)
"""States in which a vehicle fetches the load or has fetched it."""


async def transport_steps(store: Store, row: TransportRow) -> TransportSteps:
    """Read the steps of a transport, as far as its state says that they are reached.

    Args:
        store: the database.
        row: the transport.
    """
    if row.status not in REACHED:
        return TransportSteps()
    async with store.read() as work:
        tasks = await work.tasks.of_transport(row.id, ATTEMPTS_MOST)
        if not tasks:
            return TransportSteps()
        last = max(tasks, key=lambda task: task.opened_at_s)
        rows = await work.events.of_tasks([last.id], KINDS, EVENTS_MOST)
    legs = transport_timeline(row, [last], rows).attempts[-1].legs
    aboard_s = [leg.aboard_at_s for leg in legs if leg.aboard_at_s is not None]
    return TransportSteps(
        assigned_at_s=legs[0].since_at_s if legs else None,
        on_board_at_s=None if row.status is TransportState.ASSIGNED else min(aboard_s, default=None),
    )
