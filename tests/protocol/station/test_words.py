"""People are a station's body: their words go to it, and its answers back; its heartbeat tells what waits for a word."""

from __future__ import annotations

from defaults import PLANT
from effects import instructed, published, sent
from msgspec import UNSET
from rigs import Rig
from seals import granted, trusts_seals

from dray.body import StockChanged, StorageState, Word, WordTaken
from dray.messages import (
    CommandAnswered,
    CommandRefusal,
    MachineCommand,
    MachineCommandKind,
    PeopleAsBody,
    StationHeartbeat,
    UnconfirmedLoad,
)
from dray.protocol.station.held_loads import ONLY_LOADS
from dray.protocol.station.station import Station

KIND = MachineCommandKind
ARRIVED = MachineCommand(command="w1", kind=KIND.ARRIVED, item="shaft", quantity=12, issued_by="Maria")
LOAD = UnconfirmedLoad("ATV3", "shaft", 12, goes=True)


class ShelfRig(Rig):
    """The station of S1."""

    def __init__(self, *, people: bool = True) -> None:
        super().__init__(Station("S1", PLANT, trusts=trusts_seals))
        self.people, self.loads, self.stock, self.seq = people, (LOAD,), {"shaft": 40}, 0
        self.start()

    def sense(self) -> StorageState:
        return StorageState(
            dict(self.stock), self.seq, (), counts=not self.people, people=self.people, loads=self.loads
        )


def test_a_word_is_passed_on_and_answered_when_the_body_has_taken_it() -> None:
    rig = ShelfRig()
    effects = rig.on_message("gateway", granted("S1", ARRIVED))
    assert instructed(effects, Word) == [Word("shift-lead/w1", KIND.ARRIVED, "shaft", 12)]
    assert sent(effects, CommandAnswered) == []
    rig.stock["shaft"], rig.seq = 52, 1
    rig.report(StockChanged("shaft", 12, 1))
    effects = rig.report(WordTaken("shift-lead/w1"))
    assert sent(effects, CommandAnswered) == [CommandAnswered("w1", done=True)]
    beats = published(rig.run(rig.now_s + 10.0), StationHeartbeat)
    assert {level.item: level.level for level in beats[-1].stocks}["shaft"] == 52


def test_without_a_grant_for_its_area_nothing_is_passed_on() -> None:
    rig = ShelfRig()
    effects = rig.on_message("gateway", granted("S1", ARRIVED, areas=()))
    assert instructed(effects, Word) == []
    assert [each.reason for each in sent(effects, CommandAnswered)] == [CommandRefusal.NOT_HERE]


def test_its_heartbeat_tells_what_waits_for_a_word_and_that_it_does_no_more() -> None:
    rig = ShelfRig()
    [first] = {beat.people for beat in published(rig.run(rig.now_s + 6.0), StationHeartbeat)}
    assert first == PeopleAsBody(loads=(LOAD,))
    rig.loads = ()
    beats = published(rig.wake() + rig.run(rig.now_s + 6.0), StationHeartbeat)
    assert beats[-1].people == PeopleAsBody()


def test_a_controller_takes_no_words() -> None:
    rig = ShelfRig(people=False)
    effects = rig.on_message("gateway", granted("S1", ARRIVED))
    assert instructed(effects, Word) == []
    [answer] = sent(effects, CommandAnswered)
    assert (answer.reason, answer.detail) == (CommandRefusal.NOT_SUPPORTED, ONLY_LOADS)
    assert all(beat.people is UNSET for beat in published(rig.run(rig.now_s + 6.0), StationHeartbeat))
