"""A carrier fetches goods where a person hands them over: no station is there, and their machine is asked."""

from __future__ import annotations

from effects import instructed, sent
from trip import GOODS, Trip

from dray.body import Drive, Drop, Pick
from dray.messages import Docked, DockHeld, Phase, Reason, Resigned
from dray.protocol.vehicle.job.job_messages import GIVE_UP_AFTER

NODE = "c4"


def trip() -> Trip:
    return Trip(source=NODE, **GOODS | {"sources": (NODE,), "handed_at": NODE})


def test_it_drives_to_the_node_and_asks_the_machine_before_it_takes_anything() -> None:
    there = trip()
    assert instructed(there.out, Drive)[-1].nodes[-1] == NODE
    there.arrives()
    assert sent(there.out, Docked, to="M8") == [Docked(task="M8-1", epoch=1, station=NODE)]
    assert sent(there.out, Docked, to=NODE) == []
    assert instructed(there.out, Pick) == []
    there.opened(NODE)
    [pick] = instructed(there.out, Pick)
    assert (pick.station, pick.item, pick.quantity) == (NODE, "pump-p3", 24)


def test_it_carries_them_to_where_they_were_to_go() -> None:
    there = trip()
    there.arrives()
    there.opened(NODE)
    there.done(Pick)
    there.arrives()
    [drop] = instructed(there.out, Drop)
    assert (drop.station, drop.goal) == ("DELIVERY", "G8")


def test_while_nobody_hands_them_over_it_asks_and_tries_again() -> None:
    there = trip()
    there.arrives()
    there.opened(NODE)
    there.fails(Pick)
    there.waits()
    assert len(sent(there.out, Docked, to="M8")) == 2
    there.opened(NODE)
    assert len(instructed(there.out, Pick)) == 2
    assert there.job.phase is Phase.LOADING


def test_a_machine_that_answers_nothing_has_failed() -> None:
    there = trip()
    there.arrives()
    for _ in range(GIVE_UP_AFTER + 1):
        if there.job.ended is None:
            there.waits()
    [resigned] = sent(there.out, Resigned)
    assert resigned.reason is Reason.COORDINATOR_SILENT


def test_a_machine_that_has_it_wait_is_asked_again() -> None:
    there = trip()
    there.arrives()
    there.hears(DockHeld(task="M8-1", epoch=1, station=NODE, reason="later"))
    there.waits()
    assert len(sent(there.out, Docked, to="M8")) == 2
    assert sent(there.out, Resigned) == []
