"""One replica's part in the right of way of one district: it answers requests from the table and asks holders to make room.

It does not plan traffic: the vehicles decide which of them makes room, and where to (`yielding`). Its grants count when the
other replicas have copied them (`copies`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from msgspec.structs import replace

from dray.messages import Message, Removal
from dray.messages.fact import BookRefused
from dray.messages.floor.traffic import (
    UNSIGNED,
    Blocked,
    HoldsAsked,
    PlaceGranted,
    PlaceRequested,
    TableAcknowledged,
    TableAsked,
    TableReplicated,
    TableReported,
    YieldAsked,
)
from dray.protocol.runtime.events import NEVER_S
from dray.protocol.runtime.life import Life
from dray.protocol.runtime.throttle import Throttle
from dray.protocol.traffic.neighbours import Neighbours
from dray.protocol.traffic.numbers import FAR
from dray.protocol.traffic.reservations.allotment import FREE, Hindrance, allot
from dray.protocol.traffic.reservations.carried import Carried, absent
from dray.protocol.traffic.reservations.copies import Copies, Kept
from dray.protocol.traffic.reservations.floor_report import NEWS_S, FloorReport
from dray.protocol.traffic.reservations.impostors import Impostors
from dray.protocol.traffic.reservations.late_answers import LateAnswers
from dray.protocol.traffic.reservations.reach import Reach
from dray.protocol.traffic.reservations.recovery_poll import RecoveryPoll
from dray.protocol.traffic.reservations.reservation_table import ReservationTable
from dray.protocol.traffic.reservations.turns import ASK_S, Turns
from dray.protocol.traffic.traffic_map import IsSigned, names_no_key

TABLE_TICK = "table tick"

NEVER_GRANTED = "a request with a grant number that was never granted"
BEYOND_COUNT = "a request with a number that no vehicle reaches"
NOT_HEARD_THERE = "a request with places that were never granted, of a vehicle that is not heard there"
NOT_ON_THE_FLOOR = "a request from before its vehicle was carried away, while that is being put back"

OUTBID_S = 30.0
"""Shortest time between two epochs that the leader begins because a single agent reports a later one than its own."""

INSISTS_S = 30.0
"""Time for which people must repeat a removal before it frees the places of a key that claims to know a later one. An honest vehicle
knows no removal that people have not reported, but their older word may be under way. Gateways repeat only the newest."""

MISSES_AGAIN_S = 2.0
"""Shortest time between two questions of a copy that refuses its leader's table for the releases that it misses."""

TICK_S = 1.0
"""Interval between two requests to one holder to make room, and between two sendings of an unacknowledged copy."""


NOT_COPIED = "a reservation table that takes a place from a vehicle without its release, or has a version that is too high"

REFUSED_OFTEN = 5
"""Refusals in a row, one second apart, before people are told. After a restart a replica may have lost a vehicle's release, and
first asks the vehicle again."""


class Refusals:
    """Counts and reports the tables that one agent refuses to copy."""

    def __init__(self, life: Life) -> None:
        self._life = life
        self._throttle = Throttle()

    def tell(self, replica: str, in_a_row: int, now_s: float) -> None:
        """Note that a replica's table was refused, `in_a_row` times by now; from `REFUSED_OFTEN` on, people are told."""
        self._life.ignore(NOT_COPIED)
        if in_a_row >= REFUSED_OFTEN and self._throttle.passes(replica, now_s):
            self._life.record(BookRefused(replica))


class District:
    """The table of one district at one of its replicas.

    Args:
        district: its name.
        inside: its places.
        me: this replica.
        replicas: all of them, in the order of their turns.
        atvs: the vehicles of the plant; a recovery poll ends when all of them have answered.
        kept: the copy that an earlier run has stored; None without one.
        neighbours: what is known of the vehicles.
        reach: how much of the floor one vehicle may have.
        report: publishes the vehicles of the district to other vehicles.
        impostors: reports agents that speak in a vehicle's name.
        is_signed: whether a vehicle's request is signed by the key that it names.
    """

    def __init__(
        self,
        district: str,
        inside: frozenset[str],
        me: str,
        replicas: Sequence[str],
        atvs: Sequence[str],
        kept: Kept | None,
        neighbours: Neighbours,
        reach: Reach,
        report: FloorReport,
        impostors: Impostors,
        life: Life,
        is_signed: IsSigned = names_no_key,
    ) -> None:
        self.copies = Copies(district, me, replicas, kept, life, is_signed)
        self._district = district
        self._inside = inside
        self._me = me
        self._atvs = tuple(atvs)
        self._neighbours = neighbours
        self._reach = reach
        self._report = report
        self._impostors = impostors
        self._refusals = Refusals(life)
        self._turns = Turns(me, replicas)
        self._life = life
        self._table = ReservationTable()
        self._requests: dict[str, PlaceRequested] = {}
        """Newest request of every vehicle that holds or wants something here, or waits for an answer."""
        self._hindrances: dict[str, Hindrance] = {}
        self._owed: set[str] = set()
        """Vehicles that get an answer once their lines of the table count."""
        self._spoke_s: dict[str, float] = {}
        self._newest: dict[str, dict[bytes, tuple[int, int, int]]] = {}
        """Vehicle -> key -> removal, life and number of the newest request. Several keys only while each of them holds a place."""
        self._look_s = NEVER_S
        """When the alarm is due."""
        self._missed_s = -MISSES_AGAIN_S
        """When it last asked for releases that its copy misses."""
        self._asked_s: dict[str, float] = {}
        """Holder -> when it was asked to make room."""
        self._poll: RecoveryPoll | None = None
        """The running recovery poll, if any."""
        self._late = LateAnswers(reach)
        self._seen_before: dict[tuple[str, bytes], int] = {}
        """Vehicle and key -> grant number that it reported as seen in the recovery poll, where that is above the table's version."""
        self._outbid_s = -OUTBID_S
        """When it last began a new epoch because a vehicle reported a later one."""
        self._led_epoch = -1
        """Epoch under which this replica last took the table over."""
        self._carried = Carried(life)
        self._said_s: dict[str, tuple[int, float]] = {}
        """Vehicle -> number of the newest removal that people have reported here, and since when they have."""

    # --- its life --------------------------------------------------------------------------------

    def start(self, now_s: float) -> None:
        """Start: the leader seeks its epoch, the others listen. A replica without its memory asks the others."""
        if self.copies.lost:
            self.copies.ask()
            self._after_copies(now_s)
        elif self.copies.leader == self._me:
            self._seek(now_s)
        self._look_within(NEWS_S, now_s)

    @property
    def is_polling(self) -> bool:
        """Whether a recovery poll is running, so that all vehicles must be heard."""
        return self._poll is not None

    @property
    def listens_to(self) -> set[str]:
        """The vehicles whose heartbeats it needs: those that hold or want a place, or must be informed of something."""
        if not self.leads:
            return set()
        return {*self._table.atvs, *self._requests, *self._carried.unaware, *self._late.unknown}

    @property
    def leads(self) -> bool:
        """Whether this replica answers requests."""
        return self.copies.leads and self._poll is None

    def awaited(self, now_s: float) -> Iterator[str]:
        """Vehicles whose missing answers keep this district from granting anything."""
        if self._poll is not None:
            yield from self._poll.awaited(self._polled(), now_s)

    @property
    def table(self) -> ReservationTable:
        """The present table, including lines that do not count yet."""
        return self._table

    def names(self, atv: str) -> bool:
        """Whether a line of the table, or of the copy that is kept here, names the vehicle."""
        return any(line.atv == atv for line in self.copies.kept.reservations)

    def has(self, place: str) -> bool:
        """Whether the place belongs to the district."""
        return place in self._inside

    # --- messages --------------------------------------------------------------------------------

    def on_message(self, sender: str, message: Message, now_s: float) -> None:
        """Handle a message about this district."""
        if reason := self._turns.objection(sender, message):
            self._life.ignore(reason)
            return
        self._turns.on_replica(sender, now_s)
        match message:
            case PlaceRequested():
                self._on_request(sender, message, now_s)
            case TableReplicated():
                self._on_replicated(sender, message, now_s)
            case TableAcknowledged():
                if self.copies.on_acknowledged(sender, message):
                    self._answer()
            case TableAsked():
                self._on_asked(sender, message, now_s)
            case TableReported():
                self.copies.on_reported(sender, message)
                self._after_copies(now_s)
            case _:
                self._life.ignore("a message that a replica does not handle")
        self._look_within(NEWS_S, now_s)

    def _on_replicated(self, sender: str, replicated: TableReplicated, now_s: float) -> None:
        silent = self._turns.is_silent(self.copies.leader, now_s)
        refused = self.copies.refused
        if not self.copies.on_replicated(sender, replicated, silent=silent):
            self._find_out(now_s)
        if self.copies.refused == refused:
            return
        self._refusals.tell(sender, self.copies.refused, now_s)
        if self.copies.misses and now_s - self._missed_s >= MISSES_AGAIN_S - 0.01:
            self._missed_s = now_s
            self.copies.ask_for_words()

    def _on_asked(self, sender: str, asked: TableAsked, now_s: float) -> None:
        silent = self._turns.is_silent(self.copies.leader, now_s)
        promises = self.copies.on_asked(sender, asked, silent=silent)
        if asked.misses:
            # The sender hears the leader.
            self.copies.on_misses(asked.misses)
            return
        if not asked.epoch:
            self._doubt(now_s)
        if not promises and (asked.epoch or self.copies.leader != self._me):
            self._find_out(now_s)

    def _on_request(self, sender: str, request: PlaceRequested, now_s: float) -> None:
        if not self._inside.issuperset(
            (*request.holds, *(place for group in request.groups for place in group))
        ):
            self._life.ignore("a request for a place outside of this district")
            return
        self.copies.note_life(sender, request)
        if self._poll is not None:
            if request.holds:
                self._spoke_s[sender] = now_s
            if self._poll.note(sender, request, now_s):
                self._close_poll(now_s)
            return
        if not self.copies.leads:
            if not self.copies.lost and self.copies.leader != self._me:
                asked = HoldsAsked(district=self._district, epoch=self.copies.kept.epoch)
                self._life.send(sender, asked)
                self.copies.confirm(sender, request.mark, request.seen)
                self._doubt(now_s)
            return
        if request.epoch > self.copies.kept.epoch and now_s - self._outbid_s >= OUTBID_S:
            # The vehicle knows of a later epoch than this replica does.
            self._outbid_s = now_s
            self.copies.note_highest(request.epoch)
            self._seek(now_s)
            return
        if self._is_believed(sender, request, now_s):
            self._note_request(sender, request, now_s)
            self._settle(now_s)

    def _note_request(self, sender: str, request: PlaceRequested, now_s: float) -> None:
        known, said = self._table.removal_of(sender, request.mark), request
        if request.seen > self._table.version:
            # The number belongs to the table before the recovery poll: the vehicle has seen no grant of this table yet.
            request = replace(request, seen=0)
        self._table.remove(sender, request.removal, request.mark)
        kept = self.copies.kept
        is_written = self._table.version == kept.version
        self._table.begin_life(sender, request, kept.reservations if is_written else ())
        if request.removal < known:
            if self._carried.is_being_put_back(sender):
                # The vehicle is not on the floor yet: this request is an impostor's, or an old one.
                self._life.ignore(NOT_ON_THE_FLOOR)
                return
            # The vehicle does not know that it was carried away: what it held is void. The answer says only that.
            request = replace(request, holds=(), groups=())
        else:
            self._carried.unaware.discard(sender)
        if self._is_newest(sender, request):
            if any(line.mark == request.mark for line in self._table.of(sender)):
                self._spoke_s[sender] = now_s
            # An overtaken request gives nothing back: the vehicle may hold now what it did not hold then.
            if request.removal >= known:
                oldest = self._table.strike(request, sender)
                self.copies.note_word(sender, said, struck=bool(oldest), oldest=oldest)
                self._table.renew(sender, request)
            self._requests[sender] = request
            self._owed.add(sender)
            if request.removal >= known:
                self._neighbours.on_request(sender, request, now_s)

    def _is_believed(self, sender: str, request: PlaceRequested, now_s: float) -> bool:
        """Whether a request may be the vehicle's own."""
        if max(request.life, request.seq) > FAR:
            self._life.ignore(BEYOND_COUNT)
        elif not self._late.on_request(sender, request, self._table, now_s):
            self._life.ignore(NOT_HEARD_THERE)
        elif not self._table.hears(sender, request.mark):
            self._impostors.tell(sender, now_s)
        elif request.seen > max(self._table.version, self._seen_before.get((sender, request.mark), 0)):
            self._life.ignore(NEVER_GRANTED)
        else:
            return True
        return False

    def _is_newest(self, atv: str, request: PlaceRequested) -> bool:
        """Whether a request is newer than all earlier ones under its key; if so, note it. Keys that hold nothing are forgotten."""
        by_key = self._newest.get(atv, {})
        removal, *age = by_key.get(request.mark, (0, 0, 0))
        # A vehicle that has started again may not know of a removal yet; one that people have put back may have been spoken for
        # under the last number before.
        if [request.life, request.seq] <= age and request.removal <= removal:
            return False
        holding = {line.mark for line in self._table.of(atv)}
        self._newest[atv] = {mark: newest for mark, newest in by_key.items() if mark in holding}
        self._newest[atv][request.mark] = (request.removal, request.life, request.seq)
        return True

    def spoke_s(self, atv: str) -> float:
        """When the vehicle last said what it holds here. Overtaken requests, and those under another key, do not count."""
        return self._spoke_s.get(atv, float("-inf"))

    def remove(self, removal: Removal, place: str, now_s: float) -> None:
        """A person has carried a vehicle away: free what it held. If it is being put back, reserve `place` for it."""
        atv, known = removal.atv, self._table.removal_of(removal.atv)
        insists = self._insists(removal, now_s)
        if self._poll is not None:
            if self._poll.note(atv, self._absent(removal, place), now_s, by_person=True, insists=insists):
                self._close_poll(now_s)
        if not self.leads or removal.number < known:
            if self.names(atv) or self.has(place):
                self._doubt(now_s)
            return
        if removal.number > known and (place in self._inside or self._table.of(atv)):
            self._requests.pop(atv, None)
            self._owed.discard(atv)
            places = self._table.remove(atv, removal.number)
            self._carried.free(removal, places, self._table.version)
        if insists and (places := self._table.take_back(atv, removal.number)):
            self._requests.pop(atv, None)
            self._owed.discard(atv)
            self._carried.free(removal, places, self._table.version)
        if place in self._inside and not self._carried.is_kept(removal, place):
            self._requests[atv] = self._absent(removal, place)
            self._carried.keep(removal, place)
        self._settle(now_s)
        self._look_within(NEWS_S, now_s)

    def _insists(self, removal: Removal, now_s: float) -> bool:
        """Whether people have repeated this removal for `INSISTS_S`, and no later one."""
        number, since_s = self._said_s.get(removal.atv, (-1, now_s))
        if number < removal.number:
            since_s = now_s
            self._said_s[removal.atv] = (removal.number, since_s)
        return number <= removal.number and now_s - since_s >= INSISTS_S

    def on_vehicle(self, atv: str, life: int, removal: int | None, now_s: float, *, is_news: bool) -> None:
        """A heartbeat has come. If the vehicle does not know that it was carried away, tell it: it then requests where it stands."""
        if not self.leads:
            return
        if is_news and self._table.of(atv):
            self._look_within(NEWS_S, now_s)
        if self._hindrances.get(atv, FREE).by == atv:
            # Its grant waits only for its position.
            self._settle(now_s)
        known = self._table.removal_of(atv)
        if removal is None:
            return
        if removal >= known:
            self._carried.unaware.discard(atv)
        elif self.copies.counted >= self._table.version:
            epoch, lines = self.copies.kept.epoch, self._table.of(atv)
            told = PlaceGranted(
                district=self._district, epoch=epoch, life=life, upto=0, grants=lines, removal=known
            )
            self._life.send(atv, told)

    def tick(self, now_s: float) -> None:
        """The alarm has come."""
        if self._poll is not None:
            self._poll.call(self._polled(), now_s)
            self._close_poll(now_s)
        elif self.copies.asks:
            self.copies.ask()
            self._after_copies(now_s)
        elif self.copies.is_outvoted:
            self._seek(now_s)
        elif self.copies.leads:
            self.copies.repeat()
            if self._hindrances:
                self._settle(now_s)
            self._report.tell(self._table, self.copies.kept.epoch, now_s)
        elif self._turns.mine_at_s(self.copies.kept.epoch, now_s) <= now_s:
            self._turns.lead()
            self._seek(now_s)
        else:
            self._ask_whether_they_live(now_s)
        self._look_later(now_s)

    def _doubt(self, now_s: float) -> None:
        """Find out whether the leader lives: a request, question or removal has come here although another replica leads."""
        if not (self.copies.leads or self.copies.asks or self.is_polling) and self._turns.doubt(now_s):
            self._ask_whether_they_live(now_s)

    def _find_out(self, now_s: float) -> None:
        """A single replica claims a later epoch: ask whether the leader lives; as leader, ask the other replicas."""
        if self._turns.watch(now_s):
            leads = self.copies.leader == self._me
            self._ask_whether_they_live(now_s, self._turns.others if leads else ())

    def _ask_whether_they_live(self, now_s: float, whom: Sequence[str] = ()) -> None:
        for replica in whom or self._turns.asked(self.copies.kept.epoch, now_s):
            self._turns.on_question(replica, now_s)
            self._life.send(replica, TableAsked(district=self._district, epoch=0))

    def _seek(self, now_s: float) -> None:
        self.copies.seek(self._turns.silent(now_s))
        self._after_copies(now_s)

    def _look_later(self, now_s: float) -> None:
        """Set the alarm for the next known task."""
        if self._poll is not None or self.copies.asks:
            at_s = now_s + TICK_S
        elif not self.copies.leads:
            epoch = self.copies.kept.epoch
            waits = self._turns.mine_at_s(epoch, now_s) < NEVER_S or self._turns.is_watching(epoch, now_s)
            at_s = now_s + ASK_S if waits else NEVER_S
        else:
            waits = bool(self._hindrances) or self.copies.is_behind
            at_s = now_s + TICK_S if waits else self._report.due_s
        self._look_s = at_s
        self._life.alarm((TABLE_TICK, self._district), at_s)

    def _look_within(self, span_s: float, now_s: float) -> None:
        """Set the alarm to at most `span_s` from now."""
        if self._look_s > now_s + span_s:
            self._look_s = now_s + span_s
            self._life.alarm((TABLE_TICK, self._district), self._look_s)

    # --- whose reservation table it is ------------------------------------------------------------------------

    def _after_copies(self, now_s: float) -> None:
        """An answer about copies has come: this replica may lead now, or must start a recovery poll."""
        if self.copies.needs_recovery_poll and self._poll is None:
            self._poll = RecoveryPoll(self._district, self.copies.next_turn, now_s, self._life)
            self._poll.call(self._polled(), now_s)
        elif self.copies.leads and self._led_epoch != self.copies.kept.epoch:
            self._take_over()

    def _take_over(self) -> None:
        kept = self.copies.kept
        self._led_epoch = kept.epoch
        # A new version, so that a majority has the table under this epoch before any of it is told.
        self._table = ReservationTable(kept.reservations, kept.version + 1, kept.removed)
        self._requests, self._hindrances, self._newest, self._owed = {}, {}, {}, set()
        self._late.start(None)
        self._seen_before = {}
        self._carried.take_over(one.atv for one in kept.removed)
        self._write()
        for atv in self._atvs:
            self._life.send(atv, HoldsAsked(district=self._district, epoch=kept.epoch))

    def _polled(self) -> tuple[str, ...]:
        """The vehicles that a recovery poll asks: those of the plant file, and all others that were heard."""
        return tuple(dict.fromkeys((*self._atvs, *self._neighbours.all)))

    def _close_poll(self, now_s: float) -> None:
        poll = self._poll
        if poll is None or not poll.is_over(self._polled, now_s):
            return
        version = self.copies.end_recovery_poll(poll.epoch)
        self._poll = None
        self._table = poll.table(lambda atv, holds: self._reach.may_hold(atv, holds, now_s), version)
        for atv, request in poll.told.items():
            self.copies.note_word(atv, request, struck=True)
        self._late.start(poll.keys)
        self._seen_before = {
            (atv, request.mark): request.seen
            for atv, request in poll.told.items()
            if request.seen > self._table.version
        }
        self._led_epoch = poll.epoch
        # A vehicle that holds and wants nothing here waits for no answer, and its heartbeats are not needed.
        self._requests = {
            atv: request for atv, request in poll.told.items() if request.holds or request.groups
        }
        self._hindrances, self._owed = {}, set(self._requests)
        self._newest = {
            atv: {request.mark: (request.removal, request.life, request.seq)}
            for atv, request in poll.told.items()
        }
        self._carried.take_over(one.atv for one in self._table.removed)
        self._write()
        self._settle(now_s)

    # --- answers ---------------------------------------------------------------------------------

    def _settle(self, now_s: float) -> None:
        """Grant what can be granted, have it copied, answer, and ask holders to make room."""
        self._hindrances, granted = allot(
            self._table,
            self._requests,
            lambda atv: self._neighbours.is_silent(atv, now_s),
            lambda atv, missing: self._is_within_reach(atv, missing, now_s),
        )
        self._owed |= granted
        if self._table.version > self.copies.kept.version:
            self._write()
        self._answer()
        self._ask_for_room(now_s)

    def _write(self) -> None:
        self.copies.write(self._table.version, self._table.reservations, self._table.removed)

    def _answer(self) -> None:
        """Answer the owed vehicles whose lines all count."""
        if not self.leads:
            return
        counted = self.copies.counted
        self._carried.tell(self._table, counted)
        for atv in sorted(self._owed):
            request = self._requests[atv]
            lines = self._table.of_key(atv, request.mark)
            if any(line.number > counted for line in lines):
                continue
            self._owed.discard(atv)
            hindrance = self._hindrances.get(atv, FREE)
            granted = PlaceGranted(
                district=self._district,
                epoch=self.copies.kept.epoch,
                life=request.life,
                upto=request.seq,
                grants=lines,
                blocked=hindrance.blocked,
                by=hindrance.by,
                at=hindrance.at,
                removal=self._table.removal_of(atv, request.mark),
                mark=request.mark or UNSIGNED,
            )
            self._life.send(atv, granted)
            if not lines and not request.groups:
                del self._requests[atv]

    def _ask_for_room(self, now_s: float) -> None:
        """Ask standing holders to make room for waiting vehicles; each is asked only for the most urgent one."""
        asked: set[str] = set()
        for atv in sorted(self._hindrances, key=lambda one: self._requests[one].rank):
            hindrance, request = self._hindrances[atv], self._requests[atv]
            holder = hindrance.by
            if not hindrance.holds or hindrance.blocked is not Blocked.WAIT or holder in asked:
                continue
            asked.add(holder)
            if now_s - self._asked_s.get(holder, -TICK_S) < TICK_S - 0.01:
                continue
            if self._moves(holder):
                continue
            self._asked_s[holder] = now_s
            room = YieldAsked(
                district=self._district,
                waiting=atv,
                rank=request.rank,
                avoid=request.avoid,
                chain=request.chain,
            )
            self._life.send(holder, room)

    def _is_within_reach(self, atv: str, missing: Sequence[str], now_s: float) -> bool:
        """Whether a vehicle may have these places too. A vehicle that people put back may have any."""
        if self._carried.is_being_put_back(atv):
            return True
        held = [line.place for line in self._table.of(atv)]
        return self._reach.covers(atv, held, missing, now_s)

    def _moves(self, atv: str) -> bool:
        """Whether a vehicle is known to be moving: then it need not be asked."""
        seen, request = self._neighbours.of(atv), self._requests.get(atv)
        return seen is not None and not seen.stands and not (request is not None and request.stands)

    def _absent(self, removal: Removal, place: str) -> PlaceRequested:
        epoch = self._poll.epoch if self._poll is not None else self.copies.kept.epoch
        return absent(self._district, removal, place if place in self._inside else "", epoch)
