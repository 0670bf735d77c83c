"""The controller of a dock, behind a broker."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

from dray.adapters.controller.body import ControllerBody
from dray.adapters.controller.letters import TOLD, prefix
from dray.adapters.journal.sqlite_journal import SqliteJournal
from dray.adapters.vda5050.link import MqttLink
from dray.adapters.zenoh.bus import ZenohBus
from dray.body import StorageState
from dray.body.gate import GateState
from dray.cli.runtime.bodies.broker import broker_of
from dray.cli.runtime.bodies.embodied import BY_CONTROLLER, REMIND_EVERY_S, Embodied, Embody, lived
from dray.cli.runtime.surroundings import Surroundings

_log = logging.getLogger(__name__)


def by_controller(surroundings: Surroundings, name: str, senses: type[StorageState | GateState]) -> Embody:
    """The body of an agent whose dock has a controller.

    Args:
        surroundings: the process's surroundings.
        name: the agent's id.
        senses: the type of the controller's state.
    """

    @asynccontextmanager
    async def embody(_bus: ZenohBus, journal: SqliteJournal) -> AsyncIterator[Embodied]:
        broker = broker_of(surroundings.settings)
        lived(surroundings.settings.journal_folder, name, BY_CONTROLLER)
        link = MqttLink(broker, prefix(surroundings.plant.id, name), f"dray-{name}", (TOLD,))
        body = ControllerBody(journal.incarnation, senses, link.publish)
        running = asyncio.create_task(link.run(body))
        try:
            while True:
                try:
                    async with asyncio.timeout(REMIND_EVERY_S):
                        await body.known()
                    break
                except TimeoutError:
                    _log.warning("%s waits for its controller at %s", name, broker)
            yield Embodied(body, body.lost, (link.failures,))
        finally:
            running.cancel()
            await asyncio.gather(running, return_exceptions=True)

    return embody
