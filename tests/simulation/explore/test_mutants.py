"""The search is able to fail: with a safeguard taken out of the protocol, it finds a violation.

Each mutant patches the product's classes for as long as its test runs. A seed counts only if it holds
with the safeguard in place.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable
from typing import cast

import pytest
from msgspec.structs import replace
from mutants import Find, searches

from dray.body import OpenDock, WayBlocked
from dray.messages import (
    Accepted,
    Brief,
    CommandKind,
    Docked,
    DockOpened,
    Grant,
    Handover,
    Link,
    ObstacleSeen,
    Removal,
    Role,
    Transport,
    VehicleCommand,
    Work,
)
from dray.messages.floor.traffic import PlaceRequested, PlaceReservation
from dray.protocol.contract_net.auction import Auction
from dray.protocol.contract_net.changes import TaskDelivered
from dray.protocol.contract_net.coordinator import Coordinator
from dray.protocol.contract_net.task import CarrierContract, OpenTask
from dray.protocol.contract_net.task_state import TaskState
from dray.protocol.liveness.progress import Progress
from dray.protocol.people.command_authorisation import CommandAuthorisation
from dray.protocol.runtime.events import Publish
from dray.protocol.strategist.order_book import OrderInWork
from dray.protocol.strategist.order_revocations import OrderRevocations
from dray.protocol.takeover import left_aboard
from dray.protocol.traffic.driving import place_requests, yielding
from dray.protocol.traffic.driving.evidence import Evidence
from dray.protocol.traffic.driving.place_requests import PlaceRequests
from dray.protocol.traffic.places import Places
from dray.protocol.traffic.removal_authorisation import RemovalAuthorisation
from dray.protocol.traffic.reservations import reservation_handling
from dray.protocol.traffic.reservations.copies import Copies
from dray.protocol.traffic.reservations.district import District
from dray.protocol.traffic.reservations.reach import Reach
from dray.protocol.traffic.reservations.reservation_table import ReservationTable
from dray.protocol.transports import transports
from dray.protocol.transports.called import CalledTransports
from dray.protocol.transports.dock import Dock
from dray.protocol.transports.handovers import Handovers
from dray.protocol.transports.transport_flow import TransportFlow
from dray.protocol.transports.transports import Transports
from dray.protocol.vehicle.atv import Atv
from dray.protocol.vehicle.obstacle_handling import ObstacleHandling
from dray.protocol.vehicle.people.command_handling import CommandHandling
from dray.protocol.vehicle.status_report import StatusReport
from dray_sim.bodies.obstacles import Obstacles as FloorObstacles
from dray_sim.clock import computer
from dray_sim.explore.run import draw
from dray_sim.factory.request_keys import RequestKeys

Mutant = Callable[[pytest.MonkeyPatch], None]


def without_the_fence(patch: pytest.MonkeyPatch) -> None:
    """A dock takes the word of any carrier of a task, whatever its epoch, also when the task has ended."""
    on_docked = Dock.on_docked
    works: dict[str, Transport] = {}

    def open_to_all(self: Dock, sender: str, message: Docked, now_s: float) -> None:
        task = self._tasks.get(message.task)
        if task is not None and isinstance(task.work, Transport):
            works[message.task] = task.work
        if message.task not in works or (task is not None and task.primary == sender):
            on_docked(self, sender, message, now_s)
            return
        work = works[message.task]
        if message.station == self._place:
            opening = OpenDock(vehicle=sender, item=work.item, quantity=work.quantity)
            self._life.instruct(opening)
        opened = DockOpened(task=message.task, epoch=message.epoch, station=message.station)
        self._life.send(sender, opened)

    def take_from_all(self: Handovers, sender: str, message: Handover, now_s: float) -> None:
        self._dock._accept(sender, message.task, message.epoch)
        task = self._tasks.get(message.task)
        if task is not None:
            self._tasks.close(task, "delivered")
            self._life.note(TaskDelivered(task, "", cast(Transport, task.work).quantity))

    patch.setattr(Dock, "on_docked", open_to_all)
    patch.setattr(Handovers, "on_handover", take_from_all)


def with_handovers_that_count_twice(patch: pytest.MonkeyPatch) -> None:
    """A handover that is said again, since its answer was lost, is taken for another one."""
    on_handover = Dock.on_handover
    handed: dict[str, OpenTask] = {}

    def take_again(self: Dock, sender: str, message: Handover) -> OpenTask | None:
        task = self._tasks.get(message.task)
        if task is None and message.task in handed:
            again = self._tasks._open[message.task] = handed[message.task]
            again.states.now = TaskState.ASSIGNED
            again.contract = CarrierContract(sender)
            self.accept(again)
            return None
        if task is not None:
            handed[message.task] = task
        return on_handover(self, sender, message)

    patch.setattr(Dock, "on_handover", take_again)


def without_release_after_silence(patch: pytest.MonkeyPatch) -> None:
    """A coordinator gives up on a silent bidder and does not say so."""
    patch.setattr(Auction, "_release", lambda *_: None)


def that_resumes_unacknowledged(patch: pytest.MonkeyPatch) -> None:
    """A vehicle drives on at the word, whether or not anybody has seen to it before."""
    try_command = CommandHandling._try

    def obey(self: CommandHandling, command: VehicleCommand, grant: Grant, now_s: float) -> str:
        if command.kind is CommandKind.RESUME:
            self.acknowledged = True
        return try_command(self, command, grant, now_s)

    patch.setattr(CommandHandling, "_try", obey)


def that_gives_orders_back_with_an_open_gate(patch: pytest.MonkeyPatch) -> None:
    """A strategist ends the goals of an order that is taken back, and lets in what is on the way."""

    def give_back(self: OrderRevocations, order: OrderInWork) -> None:
        for goal in list(order.goals.values()):
            self._auctions.close_goal(goal, "withdrawn")
            self._book.withdraw(goal)
        self._ends.end_if_done(order)

    patch.setattr(OrderRevocations, "shut", give_back)


def that_obeys_everywhere(patch: pytest.MonkeyPatch) -> None:
    """A vehicle does not ask for which areas a grant is."""
    patch.setattr(CommandAuthorisation, "covers", lambda *_: True)


def that_believes_every_signature(patch: pytest.MonkeyPatch) -> None:
    """A vehicle does not ask who has signed a grant."""
    patch.setattr(CommandAuthorisation, "knows", lambda *_: True)


def that_passes_tasks_on_within_an_epoch(patch: pytest.MonkeyPatch) -> None:
    """A machine asks the secondary in a planned takeover, and lets the epoch be."""
    pass_on = Transports.pass_on

    def pass_on_unfenced(self: Transports, task: OpenTask, reason: str, now_s: float) -> None:
        task.epoch -= 1
        pass_on(self, task, reason, now_s)

    patch.setattr(Transports, "pass_on", pass_on_unfenced)


def that_leaves_with_a_load(patch: pytest.MonkeyPatch) -> None:
    """A vehicle that is asked to leave does so with a load on board."""

    def is_held(self: Atv) -> bool:
        job = self._contracts.job
        return job is not None and job.is_given_back

    patch.setattr(Atv, "_is_held", is_held)


def that_asks_an_auction_for_standing_contracts(patch: pytest.MonkeyPatch) -> None:
    """A coordinator takes a carrier that starts again for the answer to an auction."""

    def on_accepted(self: Coordinator, sender: str, answer: Accepted, now_s: float) -> None:
        task = self._present(answer)
        if task is None:
            self._release(sender, answer, "the task has ended")
        elif answer.role is Role.PRIMARY:
            task.auction.on_accepted(sender, answer)
            if task.auction.winner == sender and not task.primary:
                self._contract(task, sender, answer, now_s)

    patch.setattr(Coordinator, "on_accepted", on_accepted)


def that_gives_epochs_of_which_it_has_no_notes(patch: pytest.MonkeyPatch) -> None:
    """A machine without notes goes on with a task that it knows from its carrier alone, as with any other."""

    def believe(self: Transports, atv: str, brief: Brief, work: Work, now_s: float) -> None:
        auction = self._auction(brief.task, brief.epoch, work, now_s)
        task = self._open[brief.task] = OpenTask(brief.task, work, auction, now_s)
        self._bind_carrier(task, atv, brief.epoch, now_s, now_s)

    patch.setattr(Transports, "acknowledge_unknown", believe)


def that_believes_every_handover(patch: pytest.MonkeyPatch) -> None:
    """A machine takes a carrier's word for it that a load is down."""
    on_handover = Dock.on_handover

    def believe(self: Dock, sender: str, message: Handover) -> OpenTask | None:
        task = self._tasks.get(message.task)
        if task is not None:
            task.witnessed = False
        return on_handover(self, sender, message)

    patch.setattr(Dock, "on_handover", believe)


def that_waits_for_whoever_lives(patch: pytest.MonkeyPatch) -> None:
    """A machine does not ask whether its carrier comes nearer, as long as it is heard."""
    patch.setattr(Progress, "on_heartbeat", lambda *_: "")


def with_clocks_that_jump(patch: pytest.MonkeyPatch) -> None:
    """An agent's clock follows its computer's at once, wherever that is set."""
    patch.setattr(computer, "SLEW_FRAC", 1e6)


def that_believes_that_vehicles_are_away_which_are_heard(patch: pytest.MonkeyPatch) -> None:
    """Whoever keeps a reservation table frees a vehicle's places at the word, whether or not the vehicle is heard."""
    patch.setattr(RemovalAuthorisation, "objection", lambda *_: "")
    patch.setattr(reservation_handling, "REQUESTED_S", 0.0)


def that_believes_stale_removals(patch: pytest.MonkeyPatch) -> None:
    """Whoever keeps a reservation table believes a word that was given before the vehicle came back, when it is silent once more."""
    objection, remove = RemovalAuthorisation.objection, District.remove

    def forget_when(self: RemovalAuthorisation, removal: Removal, since_s: float, now_s: float) -> str:
        last = self._neighbours.last(removal.atv)
        life, seq = last.said if last is not None else (0, 0)
        patched = replace(removal, life=life, seq=seq)
        self._trusts = lambda *_: True
        return objection(self, patched, since_s, now_s)

    def take_for_new(self: District, removal: Removal, place: str, now_s: float) -> None:
        number = self.table.removal_of(removal.atv) + bool(self.table.of(removal.atv))
        remove(self, replace(removal, number=max(number, removal.number)), place, now_s)

    patch.setattr(RemovalAuthorisation, "objection", forget_when)
    patch.setattr(District, "remove", take_for_new)


def that_works_out_of_service(patch: pytest.MonkeyPatch) -> None:
    """A vehicle says that it is out of service, and bids as ever."""
    unfit = StatusReport.unfit

    def fit(self: StatusReport, link: Link) -> str:
        why = unfit(self, link)
        return "" if why == "out of service" else why

    patch.setattr(StatusReport, "unfit", fit)


def that_grants_without_the_book(patch: pytest.MonkeyPatch) -> None:
    """Whoever keeps a reservation table grants every place that is asked for, whoever holds it."""

    def write(self: ReservationTable, line: PlaceReservation) -> None:
        before = self._lines.get(line.place)
        if before is not None:
            del self._by_atv[before.atv][line.place]
        self._lines[line.place] = line
        self._by_atv.setdefault(line.atv, {})[line.place] = line

    patch.setattr(ReservationTable, "holder", lambda _self, _place: "")
    patch.setattr(ReservationTable, "_write", write)


def that_believes_releases_too_early(patch: pytest.MonkeyPatch) -> None:
    """A place is struck out on a word that was said before its grant was seen."""

    def strike(self: ReservationTable, request: PlaceRequested, atv: str) -> bool:
        gone = [line.place for line in self.of(atv) if line.place not in request.holds]
        self._rub_out(atv, gone)
        return bool(gone)

    patch.setattr(ReservationTable, "strike", strike)


def that_gives_whatever_is_asked_for(patch: pytest.MonkeyPatch) -> None:
    """A reservation table gives a vehicle all that it says it wants, wherever that is."""
    patch.setattr(Reach, "covers", lambda *_: True)


def that_believes_whoever_has_a_name(patch: pytest.MonkeyPatch) -> None:
    """A reservation table takes requests for a vehicle's own that bear its name, whatever key they are signed with."""
    patch.setattr(PlaceRequested, "mark", b"")
    patch.setattr(RequestKeys, "is_signed", lambda *_: True)


def that_does_not_examine_signatures(patch: pytest.MonkeyPatch) -> None:
    """Whoever keeps a reservation table looks at the key that a request names, and not at its signature."""
    patch.setattr(RequestKeys, "is_signed", lambda *_: True)


def that_follows_whoever_says_a_later_epoch(patch: pytest.MonkeyPatch) -> None:
    """Whoever keeps a copy follows one replica that says a later epoch, and does not ask whether the present one lives."""
    patch.setattr(Copies, "_follows", lambda *_args, **_words: True)
    patch.setattr(Evidence, "is_agreed", lambda *_: True)


def that_believes_one_replica_alone(patch: pytest.MonkeyPatch) -> None:
    """A vehicle takes the grant of one replica under an epoch that nobody else has told."""
    patch.setattr(Evidence, "is_agreed", lambda *_: True)


def that_does_not_mind_its_double(patch: pytest.MonkeyPatch) -> None:
    """A vehicle that is answered what it has not said goes on as before."""
    patch.setattr(PlaceRequests, "is_anothers", lambda *_: False)


def that_believes_the_replica_that_leads_alone(patch: pytest.MonkeyPatch) -> None:
    """A vehicle takes what it is granted, whatever the witness has."""
    patch.setattr(place_requests, "WITNESS_ASKED", -1)


def that_takes_groups_in_halves(patch: pytest.MonkeyPatch) -> None:
    """A vehicle takes an entry without its dock, and waits there."""
    patch.setattr(Places, "group_end", lambda _self, _nodes, first: first)


def that_keeps_inherited_ranks_for_ever(patch: pytest.MonkeyPatch) -> None:
    """A rank that nobody renews is inherited on."""
    patch.setattr(yielding, "LAPSE_S", 1e9)


def that_never_forget_obstacles(patch: pytest.MonkeyPatch) -> None:
    """Whoever has once heard that something lies on a lane goes round it for ever."""
    patch.setattr(ObstacleHandling, "_look_again", lambda *_: None)


def that_tell_nobody_of_obstacles(patch: pytest.MonkeyPatch) -> None:
    """Whoever meets something goes round it, and lets the others meet it too."""
    meet = ObstacleHandling._way_blocked

    def keep(self: ObstacleHandling, report: WayBlocked, now_s: float) -> None:
        meet(self, report, now_s)
        told = [
            one
            for one in self._life.effects
            if isinstance(one, Publish) and type(one.message) is ObstacleSeen
        ]
        self._life.effects[:] = [one for one in self._life.effects if one not in told]

    patch.setattr(ObstacleHandling, "_way_blocked", keep)


def with_bodies_that_see_nothing(patch: pytest.MonkeyPatch) -> None:
    """A body drives on, whatever lies before it."""
    patch.setattr(FloorObstacles, "room_m", lambda *_: None)


def that_forgets_what_it_has_brought(patch: pytest.MonkeyPatch) -> None:
    """A place does not remember which transports have ended, and takes one that is asked for again for another."""
    patch.setattr(CalledTransports, "_note_ended", lambda *_: None)


def that_calls_off_in_words_only(patch: pytest.MonkeyPatch) -> None:
    """A place says that a transport is called off, and lets its vehicle go on."""
    patch.setattr(TransportFlow, "cancel", lambda *_: None)


def that_lets_calls_stand_back_for_ever(patch: pytest.MonkeyPatch) -> None:
    """What people call for with time to spare never gets older: it is given to nobody."""
    stands_back, most_urgent = transports.stands_back, transports.most_urgent

    def is_low(task: OpenTask) -> bool:
        return task.id.startswith("T-") and task.auction.terms.deadline_s > task.auction.needed_s

    def stand_back(task: OpenTask, others: Iterable[OpenTask]) -> bool:
        return is_low(task) or stands_back(task, others)

    def find(tasks: Iterable[OpenTask], atv: str, abilities: Collection[str]) -> OpenTask | None:
        return most_urgent([task for task in tasks if not is_low(task)], atv, abilities)

    patch.setattr(transports, "stands_back", stand_back)
    patch.setattr(transports, "most_urgent", find)


def that_makes_goods_again_at_once(patch: pytest.MonkeyPatch) -> None:
    """A machine gives goods up as soon as the vehicle that has them on board is silent."""
    patch.setattr(left_aboard, "WRITTEN_OFF_AFTER_S", 1.0)


MUTANTS = [
    pytest.param(that_forgets_what_it_has_brought, "calls", 0, "invariant 23", id="brought-twice"),
    pytest.param(
        that_calls_off_in_words_only, "calls", 0, "invariant 23 .*was called off", id="called-off-and-brought"
    ),
    pytest.param(that_lets_calls_stand_back_for_ever, "calls", 0, "invariant 1 .*T-", id="low-calls-starve"),
    pytest.param(that_works_out_of_service, "hands", 0, "invariant 16", id="works-out-of-service"),
    pytest.param(that_waits_for_whoever_lives, "liars", 0, "invariant 1", id="no-progress-deadline"),
    pytest.param(with_clocks_that_jump, "clocks", 0, "invariant 6", id="clocks-that-jump"),
    pytest.param(
        that_believes_every_handover,
        *("liars", 16, "invariant 1|quiet phase has not ended"),
        id="handover-unseen",
    ),
    pytest.param(without_the_fence, "links", 0, "invariant 2", id="no-fence"),
    pytest.param(with_handovers_that_count_twice, "answers", 0, "ended twice", id="handover-twice"),
    pytest.param(without_release_after_silence, "answers", 17, "invariant 3|still works", id="no-release"),
    pytest.param(that_resumes_unacknowledged, "hands", 0, "invariant 5", id="no-acknowledge"),
    pytest.param(
        that_gives_orders_back_with_an_open_gate,
        *("revocations", 0, "invariant 4"),
        id="open-gate",
    ),
    pytest.param(that_passes_tasks_on_within_an_epoch, "updates", 0, "invariant 2", id="no-higher-epoch"),
    pytest.param(that_leaves_with_a_load, "updates", 0, "invariant 6", id="leaves-with-a-load"),
    pytest.param(
        that_asks_an_auction_for_standing_contracts, "restarts", 0, "invariant 6", id="contracts-at-restarts"
    ),
    pytest.param(
        that_gives_epochs_of_which_it_has_no_notes, "one-level", 366, "invariant 2", id="epochs-unknown"
    ),
    pytest.param(that_never_forget_obstacles, "obstacles-alone", 0, "invariant 21", id="obstacles-for-ever"),
    pytest.param(that_tell_nobody_of_obstacles, "obstacles-alone", 0, "invariant 21", id="obstacles-untold"),
    pytest.param(with_bodies_that_see_nothing, "obstacles-alone", 0, "invariant 20", id="blind-bodies"),
    pytest.param(that_makes_goods_again_at_once, "deaths", 0, "invariant 27", id="stranded-goods"),
    pytest.param(that_obeys_everywhere, "hands", 0, "invariant 9", id="no-areas"),
    pytest.param(that_believes_every_signature, "hands", 0, "invariant 9", id="no-signature"),
]
"""A mutant, from where runs are drawn, the seed to begin with, and what will be seen."""


TRAFFIC_MUTANTS = [
    pytest.param(
        that_believes_that_vehicles_are_away_which_are_heard,
        *("carried", 3, "invariant 1[34]"),
        id="away-though-heard",
    ),
    pytest.param(
        that_believes_stale_removals,
        *("carried", 184, "invariant 1[34]"),
        id="stale-removal",
    ),
    pytest.param(that_grants_without_the_book, "one-level", 0, "invariant 1[34]", id="no-table"),
    pytest.param(that_believes_releases_too_early, "one-level", 69, "invariant 1[34]", id="released-early"),
    pytest.param(that_gives_whatever_is_asked_for, "liars", 70, "invariant 29", id="no-reach"),
    pytest.param(that_believes_whoever_has_a_name, "liars", 0, "invariant 1[34]", id="no-key"),
    pytest.param(that_does_not_examine_signatures, "liars", 0, "invariant 1[34]", id="no-request-signature"),
    pytest.param(
        that_follows_whoever_says_a_later_epoch, "liars", 10, "invariant (1[34]|29)", id="follows-usurpers"
    ),
    pytest.param(
        that_believes_one_replica_alone, "liars", 10, "invariant (1|6|13|14) ", id="one-replica-alone"
    ),
    pytest.param(that_does_not_mind_its_double, "liars", 8, "invariant 1 ", id="no-double"),
    pytest.param(
        that_believes_the_replica_that_leads_alone, "liars", 5, "invariant (1|6|13|14) ", id="no-witness"
    ),
    pytest.param(that_takes_groups_in_halves, "batteries", 4, "invariant [16]", id="half-groups"),
    pytest.param(that_keeps_inherited_ranks_for_ever, "faultless", 1, "invariant [16] ", id="no-lapse"),
]
"""Likewise, with right of way."""


@pytest.mark.parametrize(("mutant", "profile", "first", "finding"), searches(MUTANTS, "no-fence"))
def test_the_search_finds_a_mutant(
    mutant: Mutant, profile: str, first: int, finding: str, find: Find
) -> None:
    find(mutant, lambda seed: draw(seed, profile), first, finding)


@pytest.mark.parametrize(
    ("mutant", "profile", "first", "finding"),
    searches(TRAFFIC_MUTANTS, "no-table", "no-reach", "no-key", "no-double", "follows-usurpers"),
)
def test_the_search_finds_a_mutant_of_right_of_way(
    mutant: Mutant, profile: str, first: int, finding: str, find: Find
) -> None:
    find(mutant, lambda seed: draw(seed, profile, traffic=True), first, finding)
