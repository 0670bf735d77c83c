"""The judge of what processes have said and heard: it finds what is planted, and nothing in what is well."""

from __future__ import annotations

from itertools import count
from pathlib import Path

import msgspec
import pytest

from dray.adapters.telemetry.traffic_log import (
    BEGUN,
    HEARD,
    SAID,
    Line,
    TrafficLog,
    TrafficLoggedBus,
    read_traffic_log,
)
from dray.codec import encode
from dray.messages import Message, PlaceGranted, PlaceRequested
from dray.messages.floor.traffic import PlaceReservation
from dray.plant import load_plant
from dray.protocol.traffic.places import Places
from dray_sim.checks.floor.traffic_log_check import (
    GRANTED_TWICE,
    HELD_TWICE,
    NOT_HELD,
    OVERLAP,
    TrafficLogCheck,
)

PLACES = Places(load_plant("single-track"))
PLACE = "b3"
DISTRICT = PLACES.district_of[PLACE]
REPLICA = PLACES.replicas_of[DISTRICT][0]


class Story:
    """Lines, one a second."""

    def __init__(self) -> None:
        self.lines: list[Line] = []
        self._at_s = count(1.0)

    def add(self, agent: str, life: int, did: str, other: str, message: Message) -> None:
        sender = agent if did == SAID else other
        raw = msgspec.Raw(encode(sender, message))
        self.lines.append(Line(next(self._at_s), agent, life, did, other, raw))

    def requests(
        self, atv: str, *holds: str, seen: int = 0, life: int = 1, wants: str = "", stands: bool = True
    ) -> None:
        request = PlaceRequested(
            district=DISTRICT,
            life=life,
            seq=1,
            epoch=0,
            rank=(0, 0.0, atv),
            holds=holds,
            groups=((wants,),) if wants else (),
            seen=seen,
            stands=stands,
            docked=False,
        )
        self.add(atv, life, SAID, REPLICA, request)

    def grants(
        self, atv: str, number: int, *, life: int = 1, arrives: bool = True, replica: str = REPLICA
    ) -> None:
        lines = (PlaceReservation(place=PLACE, number=number),)
        granted = PlaceGranted(district=DISTRICT, epoch=0, life=life, upto=1, grants=lines)
        self.add(replica, 1, SAID, atv, granted)
        if arrives:
            self.add(atv, life, HEARD, replica, granted)

    def drives(self, atv: str, start: str, end: str) -> None:
        self.lines.append(Line(next(self._at_s), atv, lane=(start, end)))

    @property
    def found(self) -> dict[str, int]:
        return dict(TrafficLogCheck(PLACES).judge(self.lines).counts)


def test_a_place_that_is_given_back_may_be_granted_to_the_next_one() -> None:
    story = Story()
    story.grants("ATV1", 1)
    story.requests("ATV1", seen=1)
    story.grants("ATV2", 2)
    assert story.found == {}


def test_a_place_that_is_granted_while_another_vehicle_holds_it_is_found_on_both_sides() -> None:
    story = Story()
    story.grants("ATV1", 1)
    story.grants("ATV2", 2)
    assert story.found == {GRANTED_TWICE: 1, HELD_TWICE: 1}


def test_a_request_that_was_said_before_the_grant_was_seen_gives_nothing_back() -> None:
    story = Story()
    story.grants("ATV1", 1)
    story.requests("ATV1", seen=0)
    story.grants("ATV2", 2, arrives=False)
    assert story.found == {GRANTED_TWICE: 1}


def test_a_killed_vehicle_holds_what_it_held_until_its_next_life_has_seen_it() -> None:
    story = Story()
    story.grants("ATV1", 1)
    story.requests("ATV1", life=2)
    story.grants("ATV1", 2, life=2)
    story.requests("ATV1", seen=2, life=2)
    story.grants("ATV2", 3)
    assert story.found == {}
    early = Story()
    early.grants("ATV1", 1)
    early.requests("ATV1", life=2)
    early.grants("ATV2", 2)
    assert early.found == {GRANTED_TWICE: 1, HELD_TWICE: 1}


def test_two_that_say_they_stand_in_one_place_are_found() -> None:
    story = Story()
    story.requests("ATV1", PLACE)
    story.requests("ATV2", PLACE)
    assert story.found == {HELD_TWICE: 1}


def test_one_number_is_given_to_one_vehicle() -> None:
    story = Story()
    story.grants("ATV1", 1, arrives=False)
    story.grants("ATV2", 1, arrives=False)
    assert story.found == {GRANTED_TWICE: 1}


def test_what_a_vehicle_does_not_heed_gives_it_nothing() -> None:
    story = Story()
    story.grants("ATV1", 1)
    story.grants("ATV2", 2, replica=PLACES.replicas_of[DISTRICT][1])
    assert HELD_TWICE not in story.found


def test_a_lane_is_driven_with_its_places_only() -> None:
    (start, end), *_ = [
        ends
        for ends in ((lane.start, lane.end) for lane in load_plant("single-track").roads.lanes)
        if ends[1] == PLACE
    ]
    story = Story()
    story.drives("ATV1", start, end)
    story.grants("ATV1", 1)
    story.drives("ATV1", start, end)
    assert story.found == {NOT_HELD: 1}


def test_the_floors_word_for_an_overlap_counts_and_a_new_floor_is_empty() -> None:
    story = Story()
    story.grants("ATV1", 1)
    story.lines.append(Line(50.0, "ATV1", overlap="ATV2"))
    story.lines.append(Line(51.0, "", did=BEGUN))
    story._at_s = count(52.0)
    story.grants("ATV2", 1)
    assert story.found == {OVERLAP: 1}


def test_waits_are_counted_from_the_request_to_the_way() -> None:
    story = Story()
    story.requests("ATV1", wants=PLACE)
    story.requests("ATV1", wants=PLACE)
    story.requests("ATV1", stands=False)
    story.requests("ATV2", wants=PLACE)
    story.requests("ATV3")
    judgement = TrafficLogCheck(PLACES).judge(story.lines)
    assert [wait.waited_s for wait in judgement.waits] == [2.0]
    assert {atv: wait.waited_s for atv, wait in judgement.waiting.items()} == {"ATV2": 1.0}
    assert judgement.longest_s == 2.0


def test_a_table_that_names_somebody_else_is_found() -> None:
    story = Story()
    story.grants("ATV1", 1)
    judge = TrafficLogCheck(PLACES)
    judge.judge(story.lines)
    assert judge.disagreement({DISTRICT: {PLACE: "ATV1"}}) == []
    assert len(judge.disagreement({DISTRICT: {PLACE: "ATV2"}})) == 1
    assert len(judge.disagreement({DISTRICT: {}})) == 1


class _Bus:
    """Passes what is said to whoever has joined last."""

    def join(self, agent: str, receive: object, life: int = 0) -> _Bus:
        self.receive = receive
        return self

    def send(self, to: str, message: Message) -> None:
        self.receive(to, message)  # type: ignore[operator]

    def leave(self) -> None:
        """Nobody is there."""


def test_what_is_said_and_what_has_come_is_in_the_file_in_that_order(tmp_path: Path) -> None:
    session = TrafficLoggedBus(_Bus(), tmp_path / "new").join("ATV1", lambda *_: None, 3)  # type: ignore[arg-type]
    story = Story()
    story.requests("ATV1", PLACE)
    request = story.lines[0].message
    session.send(REPLICA, request)
    session.leave()
    said, heard = read_traffic_log(tmp_path / "new")
    assert (said.did, heard.did, said.life, said.message) == (SAID, HEARD, 3, request)
    assert said.at_s <= heard.at_s


def test_a_folder_that_cannot_be_written_is_told_once_and_ends_nobody(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    file = tmp_path / "file"
    file.touch()
    log = TrafficLog(file, "ATV1")
    log.write(Line(1.0, "ATV1"))
    log.write(Line(2.0, "ATV1"))
    assert [record.levelname for record in caplog.records] == ["WARNING"]
