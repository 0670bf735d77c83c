"""Who has stolen the certificate of the replica that leads a reservation table: it gives no place to two, whatever it tells whom. M1 leads and is the thief; M2 is the witness."""

from __future__ import annotations

from random import Random

import pytest
from msgspec import UNSET
from msgspec.structs import replace
from trio import NAMES, Trio, line

from dray.messages.floor.traffic import (
    GivenBack,
    HoldsAsked,
    PlaceConfirmed,
    PlaceGranted,
    PlaceRequested,
    PlaceReservation,
    TableReplicated,
    TableReported,
)
from dray.protocol.runtime.events import Send
from dray.protocol.runtime.life import Life
from dray.protocol.traffic.driving import evidence
from dray.protocol.traffic.driving.evidence import WITNESS_ASKED, Evidence
from dray.protocol.traffic.driving.place_requests import LEAST_AGAIN_S, PlaceRequests, State
from dray.protocol.traffic.numbers import FAR
from dray.protocol.traffic.reservations.copies import Copies
from dray.protocol.traffic.reservations.reservation_table import ReservationTable
from dray.protocol.traffic.reservations.witness import Witness

COPIES = ("M2", "M3")
WANTED = (("b3",),)


class Vehicle:
    """One that wants the place, or holds it, and signs what it says."""

    def __init__(self, name: str, epoch: int, life: int = 1, early: tuple[PlaceConfirmed, ...] = ()) -> None:
        self.name, self.mark = name, name.encode()
        self.life = Life()
        self.out = self.life.effects
        self.state = State((0, 0.0, name), stands=True, docked=False, avoid=(), chain=())
        sign = lambda request: replace(request, key=self.mark, signature=self.mark)  # noqa: E731
        self.requests = PlaceRequests(life, {"M1": NAMES}, self.life, sign)
        for confirmed in early:
            self.requests.on_confirmed("M2", confirmed)
        for copy in COPIES:
            self.requests.on_holds_asked(copy, HoldsAsked(district="M1", epoch=epoch))
        self.say((), WANTED)
        self.holds = False

    def say(
        self, holds: tuple[str, ...], groups: tuple[tuple[str, ...], ...], *, asked: bool = False
    ) -> None:
        self.requests.say("M1", holds, groups, self.state, 0.0, asked=asked)

    @property
    def said(self) -> PlaceRequested:
        return [e.message for e in self.out if isinstance(e, Send) and isinstance(e.message, PlaceRequested)][
            -1
        ]

    def on_message(self, sender: str, message: object) -> None:
        if isinstance(message, PlaceConfirmed):
            self.requests.on_confirmed(sender, message)
            answer = self.requests.take_believed("M1")
        elif isinstance(message, PlaceGranted):
            answer = (sender, message)
        elif isinstance(message, HoldsAsked):
            if self.requests.on_holds_asked(sender, message):
                held = ("b3",) if self.holds else ()
                if message.recovery_poll:
                    self.requests.say(
                        "M1", held, WANTED, self.state, 0.0, anew=True, to=sender, epoch=message.epoch
                    )
                else:
                    self.say(held, self.requests.groups("M1"), asked=True)
            return
        else:
            return
        if answer is not None and self.requests.on_granted(*answer, 1.0):
            self.holds = True
            self.say(("b3",), ())

    def give_back(self) -> PlaceRequested:
        self.holds = False
        self.say((), ())
        return self.said


class Floor(Trio):
    """The three replicas and two vehicles."""

    def __init__(self) -> None:
        super().__init__()
        self.epoch = self.lead("M1").kept.epoch
        self.vehicles = {name: Vehicle(name, self.epoch) for name in "AB"}

    def table(
        self, atv: str, number: int, *to: str, by: tuple[GivenBack, ...] = (), version: int = 0
    ) -> None:
        """M1 says that a vehicle holds the place: to these copies, and to the vehicle. The version is the number, if it is not named."""
        lines = line(atv, number, mark=atv.encode())
        replicated = TableReplicated(
            district="M1", epoch=self.epoch, version=version or number, reservations=lines, given_back=by
        )
        for copy in to:
            self.deliver("M1", Send(copy, replicated))
        self.carry()
        own = tuple(PlaceReservation(place=one.place, number=one.number) for one in lines)
        vehicle = self.vehicles[atv]
        granted = PlaceGranted(
            district="M1", epoch=self.epoch, life=vehicle.requests.life, upto=vehicle.said.seq, grants=own
        )
        vehicle.on_message("M1", granted)
        self.tell()

    def begin_next_life(self, name: str) -> GivenBack:
        """A vehicle gives back what it holds and starts again; its release."""
        before = self.vehicles[name]
        word = GivenBack(atv=name, request=before.give_back())
        self.vehicles[name] = Vehicle(name, self.epoch, before.requests.life + 1)
        return word

    def begin_epoch(self) -> None:
        """M1 leads anew, and the copies tell so."""
        self.epoch += len(NAMES)
        for vehicle in self.vehicles.values():
            for copy in COPIES:
                vehicle.requests.on_holds_asked(copy, HoldsAsked(district="M1", epoch=self.epoch))

    def pretend_poll(self) -> None:
        """M1 asks the vehicles as if in a recovery poll."""
        for vehicle in self.vehicles.values():
            asked = HoldsAsked(district="M1", epoch=self.epoch + len(NAMES), recovery_poll=True)
            vehicle.on_message("M1", asked)

    def ask_witness(self, name: str) -> None:
        """The witness receives a vehicle's newest request, as after its start."""
        said, witness = self.vehicles[name].said, self.replicas["M2"]
        witness.note_life(name, said)
        witness.confirm(name, said.mark, said.seen)
        self.carry()
        self.tell()

    def exchange(self, name: str, random: Random, late: list[tuple[str, Send]]) -> None:
        """A vehicle and the witness exchange requests and confirmations, some of which come late."""
        if random.random() < 0.2:
            self.ask_witness(name)
        if random.random() < 0.2:
            self.replicas["M2"].confirm(name, name.encode())
            self.carry()
            late += self.to_vehicles
            self.to_vehicles.clear()
        if late and random.random() < 0.5:
            self.to_vehicles.append(late.pop(random.randrange(len(late))))
            self.tell()

    def tell(self) -> None:
        """Let the vehicles hear what replicas have said to them."""
        for sender, effect in self.to_vehicles:
            self.vehicles[effect.to].on_message(sender, effect.message)
        self.to_vehicles.clear()

    @property
    def holders(self) -> set[str]:
        return {name for name, vehicle in self.vehicles.items() if vehicle.holds}


@pytest.fixture
def floor() -> Floor:
    """A holds the place."""
    floor = Floor()
    floor.table("A", 5, *COPIES)
    assert floor.holders == {"A"}
    return floor


def test_who_leads_does_not_give_a_place_to_another_one_without_its_holders_word(floor: Floor) -> None:
    floor.table("B", 6, *COPIES)
    assert floor.holders == {"A"}
    assert {floor.replicas[copy].kept.reservations[0].atv for copy in COPIES} == {"A"}


def test_with_its_holders_word_it_does(floor: Floor) -> None:
    word = GivenBack(atv="A", request=floor.vehicles["A"].give_back())
    floor.table("B", 6, *COPIES, by=(word,))
    assert floor.holders == {"B"}


def test_of_two_copies_that_are_told_different_tables_one_is_the_witness() -> None:
    floor = Floor()
    floor.table("A", 5, "M2")
    floor.table("B", 5, "M3")
    assert floor.holders == {"A"}


def test_in_an_epoch_that_it_begins_anew_it_is_the_same(floor: Floor) -> None:
    """It starts again, and has forgotten what it likes."""
    floor.begin_epoch()
    floor.table("B", 6, *COPIES)
    assert floor.holders == {"A"}


@pytest.mark.parametrize(
    "lie",
    [
        pytest.param({"signature": b"B"}, id="it has signed it itself"),
        pytest.param({"seen": 4}, id="said before that grant was seen"),
        pytest.param({"holds": ("b3",)}, id="it holds the place"),
        pytest.param({"district": "M2"}, id="about another district"),
    ],
)
def test_a_word_that_gives_nothing_back_counts_for_nothing(floor: Floor, lie: dict[str, object]) -> None:
    word = GivenBack(atv="A", request=replace(floor.vehicles["A"].give_back(), **lie))
    floor.vehicles["A"].holds = True
    floor.table("B", 6, *COPIES, by=(word,))
    assert floor.holders == {"A"}


def test_nor_does_a_word_of_before_that_a_grant_under_an_earlier_number_seems_to_follow(floor: Floor) -> None:
    """A has given the place back and gets it again; the thief keeps its word, and numbers the new grant so that the word is later."""
    word = GivenBack(atv="A", request=floor.vehicles["A"].give_back())
    floor.vehicles["A"].say((), WANTED)
    for copy in COPIES:
        free = TableReplicated(
            district="M1", epoch=floor.epoch, version=6, reservations=(), given_back=(word,)
        )
        floor.deliver("M1", Send(copy, free))
    floor.table("A", 4, *COPIES)
    assert floor.holders == set()
    floor.table("A", 7, *COPIES)
    assert floor.holders == {"A"}
    floor.table("B", 8, *COPIES, by=(word,))
    assert floor.holders == {"A"}


def test_nor_does_a_word_of_an_earlier_life_that_the_thief_has_kept_back(floor: Floor) -> None:
    """A has given the place back, but the copies never learn of it. In its next life A is granted it under the old number."""
    word = floor.begin_next_life("A")
    floor.ask_witness("A")
    floor.table("A", 5, *COPIES)
    assert floor.holders == {"A"}
    floor.table("B", 6, *COPIES, by=(word,))
    assert floor.holders == {"A"}


def test_a_later_life_believes_no_confirmation_that_was_sent_before_the_witness_knew_of_it(
    floor: Floor,
) -> None:
    """One to the earlier life was late, or the thief has a new line confirmed before the vehicle's first request arrives."""
    floor.begin_next_life("A")
    floor.replicas["M2"].confirm("A", b"A")
    floor.carry()
    floor.table("A", 5, *COPIES)
    assert floor.holders == set()
    floor.ask_witness("A")
    assert floor.holders == {"A"}


def test_nor_one_that_has_come_before_it_has_said_anything() -> None:
    early = PlaceConfirmed(district="M1", epoch=3, grants=line("A", 5, mark=b"A"))
    vehicle = Vehicle("A", 3, life=2, early=(early,))
    granted = PlaceGranted(
        district="M1", epoch=3, life=2, upto=1, grants=(PlaceReservation(place="b3", number=5),)
    )
    vehicle.on_message("M1", granted)
    assert not vehicle.holds
    vehicle.on_message("M2", replace(early, life=2))
    assert vehicle.holds


def test_a_release_counts_until_its_vehicle_has_made_itself_known_in_a_later_life(floor: Floor) -> None:
    floor.table("B", 6, *COPIES, by=(floor.begin_next_life("A"),))
    assert floor.holders == {"B"}


def pretend_lower_numbers(floor: Floor) -> None:
    """After a recovery poll numbers may begin below those that A has seen. M1 pretends one, so that A takes its old line for a new grant."""
    vehicle = floor.vehicles["A"]
    word = GivenBack(atv="A", request=vehicle.give_back())
    vehicle.say((), WANTED)
    floor.table("A", 5, *COPIES, version=6)
    floor.replicas["M2"].on_misses((PlaceReservation(place="b4", number=6, atv="A", mark=b"A"),))
    floor.carry()
    vehicle.on_message("M1", HoldsAsked(district="M1", epoch=floor.epoch, misses=6))
    floor.tell()
    assert vehicle.said.seen == 6
    floor.pretend_poll()
    floor.begin_epoch()
    floor.table("A", 5, *COPIES, version=7)
    floor.ask_witness("A")
    floor.table("B", 8, *COPIES, by=(word,))


def test_nor_does_one_of_before_a_recovery_poll_that_the_thief_alone_pretends(floor: Floor) -> None:
    pretend_lower_numbers(floor)
    assert floor.holders == {"B"}


def test_it_would_if_vehicles_believed_the_one_that_leads_that_numbers_have_fallen(
    floor: Floor, monkeypatch: pytest.MonkeyPatch
) -> None:
    take = Evidence._take
    monkeypatch.setattr(
        Evidence, "_take", lambda self, confirmed, mark: take(self, replace(confirmed, polled=FAR), mark)
    )
    pretend_lower_numbers(floor)
    assert floor.holders == {"A", "B"}


def test_a_copy_that_has_missed_it_waits_until_the_later_life_has_said_it_once_more(floor: Floor) -> None:
    """The leader is honest; its table reaches the witness only after the vehicle has started again."""
    leader, witness = floor.replicas["M1"], floor.replicas["M2"]
    leader.note_word("A", floor.begin_next_life("A").request, struck=True)
    floor.cut = {"M2"}
    leader.write(6, ())
    floor.carry()
    floor.cut = set()
    floor.ask_witness("A")
    leader.repeat()
    floor.carry()
    assert witness.kept.version == 5
    floor.tell()
    word = floor.vehicles["A"].said
    assert (word.life, word.seen, word.holds) == (2, 5, ())
    leader.note_word("A", word, struck=False)
    leader.repeat()
    floor.carry()
    assert witness.kept.version == 6


def stand_there_again(floor: Floor) -> GivenBack:
    """In the same life A is moved to where it has given the place back, and asks for it; the release, which M1 has kept back."""
    vehicle = floor.vehicles["A"]
    word = GivenBack(atv="A", request=vehicle.give_back())
    vehicle.state = replace(vehicle.state, asks=True)
    vehicle.say((), WANTED)
    floor.ask_witness("A")
    return word


def test_nor_does_one_that_was_kept_back_when_the_vehicle_stands_there_again(floor: Floor) -> None:
    word = stand_there_again(floor)
    floor.table("A", 5, *COPIES, version=5)
    floor.table("B", 6, *COPIES, by=(word,))
    assert floor.holders == {"B"}


def test_nor_one_that_was_kept_back_until_the_vehicle_has_been_granted_the_place_anew(floor: Floor) -> None:
    word = stand_there_again(floor)
    floor.table("A", 6, *COPIES)
    assert floor.holders == {"A"}
    floor.table("B", 7, *COPIES, by=(word,))
    assert floor.holders == {"A"}


def test_an_honest_leader_that_has_missed_the_release_grants_the_place_anew_once(floor: Floor) -> None:
    stand_there_again(floor)
    table = ReservationTable(line("A", 5, mark=b"A"), 5)
    asked = floor.vehicles["A"].said
    assert (asked.seen, asked.renews) == (0, 5)
    table.renew("A", asked)
    table.renew("A", asked)
    assert [(one.place, one.number, one.atv) for one in table.reservations] == [("b3", 6, "A")]


def test_the_witness_names_a_life_to_the_key_that_has_said_so_alone(floor: Floor) -> None:
    witness = floor.replicas["M2"]
    floor.begin_next_life("A")
    said = floor.vehicles["A"].said
    witness.note_life("A", replace(said, key=b"thief", life=9))
    witness.note_life("A", said)
    witness.note_life("A", replace(said, life=1))
    witness.note_life("A", replace(said, key=b"", life=7))
    for mark in (b"A", b"thief", b""):
        witness.confirm("A", mark)
    floor.carry()
    own = line("A", 5, mark=b"A")
    said_all = [effect.message for _, effect in floor.to_vehicles]
    confirmed = [message for message in said_all if isinstance(message, PlaceConfirmed)]
    assert [(message.life, message.grants) for message in confirmed] == [
        (2, own),
        (UNSET, own),
        (UNSET, own),
    ]


def test_a_copy_that_objects_asks_the_vehicle_what_it_holds(floor: Floor) -> None:
    """The replica may have lost its word, as by a restart."""
    lines = line("B", 6, mark=b"B")
    floor.deliver(
        "M1", Send("M2", TableReplicated(district="M1", epoch=floor.epoch, version=6, reservations=lines))
    )
    floor.carry()
    assert [effect.to for _, effect in floor.to_vehicles if isinstance(effect.message, HoldsAsked)] == ["A"]


def test_what_copies_miss_the_vehicle_says_once_more_when_leader_and_witness_have_asked() -> None:
    """It has started again, has seen no grant since, and the leader has struck its line out without a word that others can examine:
    it has told itself that people have carried it away."""
    floor = Floor()
    leader = floor.replicas["M1"]
    leader.write(5, line("A", 5, mark=b"A"))
    floor.carry()
    floor.to_vehicles.clear()
    leader.write(6, ())
    floor.carry()
    assert {floor.replicas[copy].kept.version for copy in COPIES} == {5}
    floor.tell()
    word = floor.vehicles["A"].said
    assert (word.seen, word.holds) == (5, ())
    leader.note_word("A", word, struck=False)
    leader.repeat()
    floor.carry()
    assert {floor.replicas[copy].kept.version for copy in COPIES} == {6}


def test_a_copy_that_misses_nothing_asks_the_vehicle_for_one_that_does() -> None:
    floor = Floor()
    leader = floor.replicas["M1"]
    leader.write(5, line("A", 5, mark=b"A"))
    floor.carry()
    floor.to_vehicles.clear()
    floor.replicas["M2"].on_misses(line("A", 5, mark=b"A"))
    floor.replicas["M2"].on_misses(line("B", 6, mark=b"B"))
    floor.carry()
    assert floor.to_vehicles == []
    floor.replicas["M2"].on_misses(line("B", 4, mark=b"B"))
    floor.carry()
    ((sender, sent),) = floor.to_vehicles
    assert (sender, sent.to) == ("M2", "B")
    assert isinstance(sent.message, HoldsAsked)
    assert sent.message.misses == 4


def settled(*told: tuple[str, int, int], holds: tuple[str, ...] = (), asks: bool = False) -> PlaceRequested:
    """What a vehicle says after these replicas have asked it, each under an epoch, for releases up to a number."""
    vehicle = Vehicle("A", 3)
    vehicle.state = replace(vehicle.state, asks=asks)
    for replica, epoch, misses in told:
        if vehicle.requests.on_holds_asked(replica, HoldsAsked(district="M1", epoch=epoch, misses=misses)):
            vehicle.say(holds, WANTED, asked=True)
    return vehicle.said


@pytest.mark.parametrize(
    ("told", "seen"),
    [
        pytest.param([("M1", 3, 9), ("M2", 3, 5)], 5, id="leader and witness"),
        pytest.param([("M2", 3, 5), ("M1", 3, 9), ("M2", 3, 7)], 7, id="and once more"),
        pytest.param([("M1", 3, 9), ("M3", 3, 9)], 0, id="not the witness"),
        pytest.param([("M2", 3, 9), ("M3", 3, 9)], 0, id="not the leader"),
        pytest.param([("M1", 3, 9), ("M1", 3, 9)], 0, id="the leader alone"),
        pytest.param([("M2", 2, 9), ("M1", 3, 9)], 0, id="the witness under an earlier epoch"),
    ],
)
def test_no_replica_alone_makes_a_vehicle_count_grants_as_seen(
    told: list[tuple[str, int, int]], seen: int
) -> None:
    assert settled(*told).seen == seen


def test_a_grant_that_was_under_way_is_void_when_the_vehicle_has_said_that_it_does_not_hold_the_place(
    floor: Floor,
) -> None:
    """The leader has struck it out since."""
    vehicle = Vehicle("B", floor.epoch)
    for replica in ("M1", "M2"):
        vehicle.on_message(replica, HoldsAsked(district="M1", epoch=floor.epoch, misses=6))
    assert vehicle.said.seen == 6
    vehicle.on_message("M2", PlaceConfirmed(district="M1", epoch=floor.epoch, grants=line("B", 6, mark=b"B")))
    own = (PlaceReservation(place="b3", number=6),)
    vehicle.on_message("M1", PlaceGranted(district="M1", epoch=floor.epoch, life=1, upto=1, grants=own))
    assert not vehicle.holds


def test_a_vehicle_that_asks_for_the_place_where_it_stands_does_not_give_that_back() -> None:
    said = settled(("M1", 3, 5), ("M2", 3, 5), asks=True)
    assert (said.seen, said.holds) == (5, ("b3",))


def test_what_a_vehicle_gives_back_that_counts_its_lives_from_one_again_counts_when_people_have_carried_it_away(
    floor: Floor,
) -> None:
    """Its journal is lost, or an old copy, and its key is not."""
    floor.vehicles["A"] = Vehicle("A", floor.epoch, life=7)
    floor.ask_witness("A")
    for copy in COPIES:
        floor.replicas[copy].on_carried("A")
    floor.vehicles["A"] = Vehicle("A", floor.epoch, life=1)
    floor.table("A", 6, *COPIES)
    assert floor.holders == {"A"}
    word = GivenBack(atv="A", request=floor.vehicles["A"].give_back())
    floor.table("B", 7, *COPIES, by=(word,))
    assert floor.holders == {"B"}


def test_whom_people_have_carried_away_gives_nothing_back_itself(floor: Floor) -> None:
    for copy in COPIES:
        floor.replicas[copy].on_carried("A")
    floor.vehicles["A"].holds = False
    floor.table("B", 6, *COPIES)
    assert floor.holders == {"B"}


def test_what_it_is_granted_afterwards_is_its_own_again(floor: Floor) -> None:
    for copy in COPIES:
        floor.replicas[copy].on_carried("A")
    floor.table("A", 6, *COPIES)
    floor.table("B", 7, *COPIES)
    assert floor.holders == {"A"}


def test_where_a_recovery_poll_was_started_since_its_table_is_copied(floor: Floor) -> None:
    """M1 and M3 had lost their memory, and M2 had not: all vehicles have told anew."""
    witness, epoch = floor.replicas["M2"], floor.epoch + len(NAMES)
    polled = TableReplicated(district="M1", epoch=epoch, version=6, reservations=line("B", 6, mark=b"B"))
    floor.deliver("M1", Send("M2", polled))
    assert witness.kept.reservations[0].atv == "A"
    told = TableReported(
        district="M1", epoch=epoch, lost=False, kept_epoch=epoch, version=6, reservations=(), began=epoch
    )
    witness.on_reported("M3", told)
    floor.deliver("M1", Send("M2", polled))
    assert witness.kept.reservations[0].atv == "B"


def test_who_takes_a_table_over_is_copied_as_it_is(floor: Floor) -> None:
    """What the one before it has written last may not have counted."""
    floor.cut = {"M1"}
    floor.lead("M2").write(6, ())
    floor.carry()
    assert floor.replicas["M3"].kept.reservations == ()


def test_words_are_said_with_the_table_until_all_have_copied_it() -> None:
    floor = Floor()
    leader = floor.replicas["M1"]
    leader.write(1, line("A", 1, mark=b"A"))
    floor.carry()
    word = replace(floor.vehicles["A"].said, seen=1)
    leader.note_word("A", word, struck=True)
    floor.cut = {"M3"}
    leader.write(2, line("B", 2, mark=b"B"))
    floor.carry()
    assert floor.replicas["M2"].kept.version == 2
    floor.cut = set()
    leader.repeat()
    floor.carry()
    assert floor.replicas["M3"].kept.version == 2
    leader.write(3, line("B", 3, mark=b"B"))
    assert all(
        not e.message.given_back
        for e in floor.lives["M1"].effects
        if isinstance(e, Send) and isinstance(e.message, TableReplicated)
    )


def test_they_are_kept_over_an_epoch_that_its_writer_begins_anew() -> None:
    """The witness has not copied the table before, and the vehicle has started again: it has seen no grant, and cannot say its word once more."""
    floor = Floor()
    leader = floor.replicas["M1"]
    leader.write(1, line("A", 1, mark=b"A"))
    floor.carry()
    floor.cut = {"M2"}
    word = replace(floor.vehicles["A"].said, seen=1)
    leader.note_word("A", word, struck=True)
    leader.write(2, ())
    floor.carry()
    floor.lead("M1")
    floor.cut = set()
    leader.write(3, line("B", 3, mark=b"B"))
    leader.note_word("A", replace(word, life=2, seen=0, groups=()), struck=False)
    leader.repeat()
    floor.carry()
    assert floor.replicas["M2"].kept.version == 3


def test_a_vehicle_asks_the_witness_and_goes_on_without_it_when_that_one_does_not_answer() -> None:
    vehicle = Vehicle("A", 3)
    vehicle.out.clear()
    granted = PlaceGranted(
        district="M1", epoch=3, life=1, upto=1, grants=(PlaceReservation(place="b3", number=5),)
    )
    vehicle.on_message("M1", granted)
    for _ in range(WITNESS_ASKED):
        assert vehicle.requests.take_believed("M1") is None
        vehicle.requests.repeat("M1", (), WANTED, vehicle.state, LEAST_AGAIN_S)
    assert [effect.to for effect in vehicle.out if isinstance(effect, Send)] == WITNESS_ASKED * ["M1", "M2"]
    assert vehicle.requests.take_believed("M1") is None
    vehicle.requests.repeat("M1", (), WANTED, vehicle.state, LEAST_AGAIN_S)
    assert vehicle.requests.take_believed("M1") == ("M1", granted)


def test_nor_as_long_as_the_witness_answers_that_it_has_no_such_line() -> None:
    vehicle = Vehicle("A", 3)
    granted = PlaceGranted(
        district="M1", epoch=3, life=1, upto=1, grants=(PlaceReservation(place="b3", number=5),)
    )
    vehicle.on_message("M1", granted)
    for _ in range(3 * WITNESS_ASKED):
        vehicle.requests.repeat("M1", (), WANTED, vehicle.state, LEAST_AGAIN_S)
        vehicle.on_message("M2", PlaceConfirmed(district="M1", epoch=3, grants=()))
    assert not vehicle.holds


def test_a_later_life_takes_a_witness_of_earlier_software_for_one_that_does_not_answer() -> None:
    """It names no life."""
    vehicle = Vehicle("A", 3, life=2)
    own = (PlaceReservation(place="b3", number=5),)
    granted = PlaceGranted(district="M1", epoch=3, life=2, upto=1, grants=own)
    vehicle.on_message("M1", granted)
    for _ in range(WITNESS_ASKED + 1):
        assert not vehicle.holds
        vehicle.requests.repeat("M1", (), WANTED, vehicle.state, LEAST_AGAIN_S)
        vehicle.on_message("M2", PlaceConfirmed(district="M1", epoch=3, grants=line("A", 5, mark=b"A")))
    assert vehicle.holds


@pytest.mark.parametrize(("sender", "mark"), [("M3", b"A"), ("M1", b"A"), ("M2", b""), ("M2", b"B")])
def test_nobody_else_confirms_and_no_line_that_any_key_gives_back(sender: str, mark: bytes) -> None:
    vehicle = Vehicle("A", 3)
    vehicle.on_message(sender, PlaceConfirmed(district="M1", epoch=3, grants=line("A", 5, mark=mark)))
    granted = PlaceGranted(
        district="M1", epoch=3, life=1, upto=1, grants=(PlaceReservation(place="b3", number=5),)
    )
    vehicle.on_message("M1", granted)
    assert not vehicle.holds


def anything(seed: int) -> bool:
    """M1 says anything, in any order. Vehicles give back what they hold and start again as they like, and what they say to the
    witness may be lost, and its answer late. Whether both have held the place at once."""
    random = Random(seed)
    floor = Floor()
    words: list[GivenBack] = []
    late: list[tuple[str, Send]] = []
    for number in range(1, 240):
        atv = random.choice("AB")
        vehicle = floor.vehicles[atv]
        if vehicle.holds and random.random() < 0.2:
            words.append(GivenBack(atv=atv, request=vehicle.give_back()))
            vehicle.say((), WANTED)
        if not vehicle.holds and random.random() < 0.2:
            words.append(floor.begin_next_life(atv))
        floor.exchange(atv, random, late)
        if random.random() < 0.2:
            # It names a release that nobody misses, and has the vehicle asked for it.
            number_missed = random.randrange(number + 5)
            for copy in COPIES:
                floor.replicas[copy].on_misses(line(atv, number_missed, mark=atv.encode()))
            vehicle.on_message("M1", HoldsAsked(district="M1", epoch=floor.epoch, misses=number_missed))
            floor.carry()
            floor.tell()
            words.append(GivenBack(atv=atv, request=vehicle.said))
        said = tuple(random.sample(words[-6:], k=min(len(words), random.randrange(3))))
        to = random.choice((COPIES, ("M2",), ("M3",), ()))
        later = random.choice((0, 0, 0, 1, 5, -3))
        if random.random() < 0.1:
            if random.random() < 0.5:
                floor.pretend_poll()
            floor.begin_epoch()
        newest = max((one.number for one in floor.replicas["M2"].kept.reservations), default=0)
        floor.table(atv, newest if random.random() < 0.2 else max(number + later, 1), *to, by=said)
        if floor.holders == {"A", "B"}:
            return True
    return False


@pytest.mark.parametrize("seed", range(40))
def test_whatever_it_says_no_two_hold_the_place(seed: int) -> None:
    assert not anything(seed)


def test_two_would_if_vehicles_believed_the_one_that_leads_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(evidence, "WITNESS_ASKED", -1)
    assert all(anything(seed) for seed in range(10))


def test_two_would_if_copies_believed_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Copies, "_objects", lambda *_: False)
    assert any(anything(seed) for seed in range(10))


def test_two_would_if_copies_believed_words_of_an_earlier_life(monkeypatch: pytest.MonkeyPatch) -> None:
    gives_back = Witness._gives_back
    monkeypatch.setattr(
        Witness,
        "_gives_back",
        lambda self, request, line: gives_back(self, replace(request, life=FAR), line),
    )
    assert any(anything(seed) for seed in range(40))


def test_two_would_if_a_later_life_believed_confirmations_to_an_earlier_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(Evidence, "_is_to_this_life", lambda *_: True)
    assert any(anything(seed) for seed in range(40))
