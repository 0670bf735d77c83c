"""A lying vehicle at a storage whose body does not count: it leaves few loads in doubt before people have to look."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable

import pytest
from defaults import PLANT
from effects import facts, instructed, published, sent
from msgspec.structs import replace
from seals import granted, trusts_seals
from spoken import rhb
from station_rig import ITEM, StationRig

from dray.body import Book, OpenDock
from dray.memory import DepartureMemory
from dray.messages import (
    CommandAnswered,
    Docked,
    DockHeld,
    HelpCall,
    MachineCommand,
    MachineCommandKind,
    StationHeartbeat,
)
from dray.messages.fact import LoadDoubted
from dray.protocol.runtime.events import Effect
from dray.protocol.runtime.life import Life
from dray.protocol.station.station import Station
from dray.protocol.transports.dock_door import IN_DOUBT
from dray.protocol.transports.doubts import ASKS_AFTER_S, DOUBTS_KEPT, DOUBTS_OF_ONE, Doubts
from dray.protocol.transports.visit import UNHEARD_S

STOCK = 400
NAMES = 2 * DOUBTS_KEPT
"""Tasks that the liar names, one after the other: more than one place remembers."""


def blind() -> StationRig:
    rig = StationRig(STOCK)
    rig.agent, rig.counts = Station("S1", PLANT, trusts=trusts_seals), False
    rig.start()
    return rig


def books(rig: StationRig, effects: list[Effect]) -> list[Effect]:
    """The storage books what it is told."""
    for book in instructed(effects, Book):
        rig.changes(book.change, book.vehicle)
    return effects


def takes(rig: StationRig, task: str, atv: str = "ATV2") -> list[Effect]:
    """A vehicle says that it stands at the dock for one piece, of whichever task."""
    return books(rig, rig.docks(atv, task, quantity=1))


def returns(rig: StationRig, task: str, atv: str = "ATV2") -> list[Effect]:
    """A vehicle says that it stands at the dock to bring one piece back."""
    return books(rig, rig.on_message(atv, Docked(task, 1, "S1", ITEM, 1, returns=True)))


def is_elsewhere(rig: StationRig, atv: str = "ATV2") -> None:
    """After a silence it is heard elsewhere, and names nothing."""
    rig.run(rig.now_s + 2 * UNHEARD_S)
    books(rig, rig.on_message(atv, replace(rhb(atv, int(rig.now_s * 10), rig.now_s), node="c1")))


def lied(does: Callable[[StationRig, str], list[Effect]]) -> StationRig:
    """ATV2 leaves one load after another in doubt."""
    rig = blind()
    for number in range(NAMES):
        does(rig, f"lie-{number}")
        is_elsewhere(rig)
    rig.run(rig.now_s + 2 * ASKS_AFTER_S)
    return rig


@pytest.mark.parametrize("does", [takes, returns])
def test_a_vehicle_that_names_task_after_task_leaves_few_loads_in_doubt(
    does: Callable[[StationRig, str], list[Effect]],
) -> None:
    rig = lied(does)
    assert len(facts(rig.all, LoadDoubted)) == DOUBTS_OF_ONE
    assert len({call.goods for call in published(rig.all, HelpCall)}) == DOUBTS_OF_ONE
    assert rig.level.level >= STOCK - DOUBTS_OF_ONE
    [held] = sent(does(rig, "lie-again"), DockHeld, to="ATV2")
    assert held.reason == IN_DOUBT


def test_the_load_of_an_honest_vehicle_stays_in_doubt_and_it_is_let_in() -> None:
    rig = blind()
    takes(rig, "M8-1", "ATV3")
    is_elsewhere(rig, "ATV3")
    for number in range(NAMES):
        takes(rig, f"lie-{number}")
        is_elsewhere(rig)
    rig.run(rig.now_s + 2 * ASKS_AFTER_S)
    assert "ATV3" in {doubt.vehicle for doubt in rig.heartbeats(StationHeartbeat)[-1].doubts}
    assert instructed(takes(rig, "M8-2", "ATV3"), OpenDock)


def test_after_people_have_looked_for_a_load_its_vehicle_is_let_in_again() -> None:
    rig = lied(takes)
    name = rig.heartbeats(StationHeartbeat)[-1].doubts[0].load
    looked = MachineCommand(command="C1", kind=MachineCommandKind.LOAD_MISSING, task=name, issued_by="Maria")
    [answer] = sent(rig.on_message("gateway", granted("S1", looked)), CommandAnswered)
    assert answer.done
    assert instructed(takes(rig, "M8-1"), OpenDock)


def test_whatever_a_vehicle_leaves_in_doubt_few_of_its_loads_are_asked_for_and_those_of_others_too() -> None:
    doubts = Doubts(Life())
    for number in range(NAMES):
        for atv in ("ATV2", f"V{number % 4}"):
            doubts.note(DepartureMemory(atv, f"{atv}-{number // 4}", 1, ITEM, 1))
    counted = Counter(doubt.load.vehicle for doubt in doubts.memories())
    assert counted == dict.fromkeys(("ATV2", "V0", "V1", "V2", "V3"), DOUBTS_OF_ONE)
