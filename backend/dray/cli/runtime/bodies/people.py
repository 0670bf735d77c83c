"""Bodies operated by people, for machines, storages and the gate."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Generic, TypeVar

from msgspec import Struct

from dray.adapters.journal.sqlite_journal import SqliteJournal
from dray.adapters.memory_file import MemoryFile
from dray.adapters.people.gate import DAMAGED_GATE, KeptGate, PeopleGate
from dray.adapters.people.store import DAMAGED_STORE as DAMAGED_PEOPLE_STORE
from dray.adapters.people.store import KeptStore as PeopleKeptStore
from dray.adapters.people.store import PeopleStore
from dray.adapters.people.workcell import DAMAGED as DAMAGED_PEOPLE
from dray.adapters.people.workcell import Kept as PeopleKept
from dray.adapters.people.workcell import PeopleWorkcell
from dray.adapters.zenoh.bus import ZenohBus
from dray.cli.runtime.bodies.embodied import BY_PEOPLE, Embodied, Embody, lived
from dray.cli.runtime.surroundings import Surroundings
from dray.plant.model import MachineSpec
from dray.plant.model import Storage as StorageSpec
from dray.ports import Body

_log = logging.getLogger(__name__)


_PeopleKept = TypeVar("_PeopleKept", bound=Struct)


class _PeopleWorld(Generic[_PeopleKept]):
    """The surroundings of a people's body, beside its clock: a disk."""

    def __init__(self, remember: Callable[[_PeopleKept], None]) -> None:
        self.remember = remember


def _of_people(
    surroundings: Surroundings,
    name: str,
    kind: type[_PeopleKept],
    damaged: _PeopleKept,
    make: Callable[[_PeopleWorld[_PeopleKept], _PeopleKept | None], Body],
) -> Embody:
    """A body operated by people; a file in the journal folder stores their reports."""

    @asynccontextmanager
    async def embody(_bus: ZenohBus, _journal: SqliteJournal) -> AsyncIterator[Embodied]:
        folder = surroundings.settings.journal_folder
        file = MemoryFile(folder / f"{name}.people.json", kind, damaged)
        kept = lived(folder, name, BY_PEOPLE, file)
        yield Embodied(make(_PeopleWorld(file.write), kept), asyncio.Event().wait)

    return embody


def by_people(surroundings: Surroundings, name: str, spec: MachineSpec) -> Embody:
    """A machine without a controller, whose people report the events.

    Args:
        surroundings: the process's surroundings.
        name: the agent's id.
        spec: the machine.
    """
    return _of_people(
        surroundings,
        name,
        PeopleKept,
        DAMAGED_PEOPLE,
        lambda world, kept: PeopleWorkcell(spec, surroundings.plant, surroundings.clock(), world, kept),
    )


def store_by_people(surroundings: Surroundings, name: str, spec: StorageSpec) -> Embody:
    """A storage or a warehouse without a controller, whose people report arrivals and removals.

    Args:
        surroundings: the process's surroundings.
        name: the agent's id.
        spec: the storage.
    """
    return _of_people(
        surroundings,
        name,
        PeopleKeptStore,
        DAMAGED_PEOPLE_STORE,
        lambda world, kept: PeopleStore(spec, world, kept),
    )


def gate_by_people(surroundings: Surroundings, name: str) -> Embody:
    """The gate of the delivery warehouses, whose people report arrivals.

    Args:
        surroundings: the process's surroundings.
        name: the agent's id.
    """
    return _of_people(surroundings, name, KeptGate, DAMAGED_GATE, PeopleGate)
