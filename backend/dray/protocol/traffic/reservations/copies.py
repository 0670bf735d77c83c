"""One reservation table, replicated on several machines: which of them may write it, and when its writes count.

This is viewstamped replication with a table small enough to be sent whole. Under each *epoch* only one replica, the leader, writes.
A majority has promised it the epoch and told it the newest copy. A write counts when a majority has it. A replica that a network
partition cuts off finds no majority: traffic in its district waits, and no place is granted twice.

A claim alone gives no epoch. A replica follows a later epoch in three cases: the present leader begins it, two other replicas report
it, or the present leader does not answer *this replica* either. So a stolen certificate of one replica cannot displace a living
leader. A replica that waits for promises gives none itself. It goes on with the present leader when that one answers.

The leader cannot write anything it likes. Replicas refuse a table that takes a place from a vehicle without its release (`witness`).
The replica whose turn is next confirms to each vehicle what it has copied. So only two lying replicas could grant a place twice.

A replica that has lost its memory takes no part until all others have answered: it may have forgotten a promise. When too few
remember, one replica asks all vehicles what they hold (a recovery poll). Another replica without memory takes the resulting table if
it has learned that the writer had lost its memory, too. Each vehicle has answered under that epoch and follows no earlier one. No
replica has reported a later epoch since, so none leads by a forgotten promise.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence

import msgspec
from msgspec import UNSET

from dray.messages.floor.traffic import (
    FIRST_LIFE,
    MISSES_MAX,
    AllGivenBack,
    AllRemoved,
    GivenBack,
    HoldsAsked,
    PlaceConfirmed,
    PlaceRequested,
    PlaceReservation,
    PlaceReservations,
    TableAcknowledged,
    TableAsked,
    TableReplicated,
    TableReported,
)
from dray.protocol.runtime.life import Life
from dray.protocol.traffic.numbers import (
    LEAP_MAX,
    OUTBID_MAX,
    highest_believed,
    is_version_believed,
    most_believed,
)
from dray.protocol.traffic.reservations.proofs import Proofs
from dray.protocol.traffic.reservations.witness import Witness
from dray.protocol.traffic.traffic_map import IsSigned, names_no_key

PATIENT_ROUNDS = 2
"""Rounds of questions to all others before the answers of a majority suffice."""


UNDER_WAY_MAX = 1_000
"""Grants that a replica may have copied beyond the version that it has acknowledged: a minute of a busy district. A replica that was
cut off for longer has none of the later ones, so the proofs that are kept for it are bounded, whatever a thief says meanwhile."""


class Kept(msgspec.Struct, frozen=True):
    """What a replica must store across restarts."""

    epoch: int = 0
    """The highest epoch that it has promised, or follows."""
    kept_epoch: int = 0
    """Epoch under which the copy was written."""
    version: int = 0
    reservations: PlaceReservations = ()
    removed: AllRemoved = ()
    given_back: AllGivenBack = ()
    """The vehicles' words by which it has struck out lines as leader, and which another replica may still need."""


class Copies:
    """One replica's part in keeping the table of a district.

    Args:
        district: whose reservation table.
        me: the replica.
        replicas: all of them, in the order of their turns; `me` is one of them.
        kept: the copy that an earlier run has stored; None when it is lost, or there was none.
        is_signed: whether a vehicle's request is signed by the key that it names.

    Attributes:
        kept: what must be stored before any message is sent.
        leads: whether `me` writes the table under the present epoch.
        counted: the highest version that a majority has.
        lost: whether it has no memory yet.
        refused: the leader's tables refused since the last one that was copied.
        misses: the lines for which the last one was refused.
        needs_recovery_poll: too few replicas remember; `me` is to ask the vehicles.
    """

    def __init__(
        self,
        district: str,
        me: str,
        replicas: Sequence[str],
        kept: Kept | None,
        life: Life,
        is_signed: IsSigned = names_no_key,
    ) -> None:
        self.district = district
        self.kept = kept or Kept()
        self.leads = False
        self.counted = 0
        self.lost = kept is None
        self.refused = 0
        self.misses: tuple[PlaceReservation, ...] = ()
        self.needs_recovery_poll = False
        self._me = me
        self._replicas = tuple(replicas)
        self._others = tuple(replica for replica in replicas if replica != me)
        self._life = life
        self._has: dict[str, int] = {}
        """Replica -> the version that it has under this epoch."""
        self._witness = Witness(district, is_signed)
        self._proofs = Proofs()
        """The requests that prove to other replicas what vehicles have given back while `me` led."""
        self._proofs.restore(self.kept.given_back, self.kept.version)
        self._led_from: int | None = None
        """The first version that it has written under this epoch; None before that. Other replicas have copied lines of earlier ones."""
        self._copied = False
        """Whether it has copied a table since its start: later tables are checked against that copy."""
        self._began = 0
        self._polled = 0
        """Epoch of the recovery poll from whose table its copy comes, if it has lost its memory in this life; 0 otherwise."""
        self._elsewhere: TableReported | None = None
        """Newest report of a replica other than the leader, since the last table was copied."""
        self._versions: dict[str, int] = {}
        """Replica -> the highest version that it has reported."""
        self._told: dict[str, TableReported] = {}
        self._highest = 0
        """The highest epoch that anybody has reported."""
        self._words: dict[str, int] = {}
        """Replica -> the highest epoch that it has reported as the present one."""
        self._sought = 0
        """The epoch for which `me` seeks promises; 0 when it does not."""
        self._absent: frozenset[str] = frozenset()
        """Replicas that are not waited for."""
        self._rounds = 0
        """How often the others were asked."""
        self._heard: dict[str, int] = {}
        """While it is lost: replica -> the highest epoch that it has reported."""
        self._lost_too: set[str] = set()
        """While it is lost: replicas that have reported that they are lost, too."""

    @property
    def majority(self) -> int:
        return len(self._replicas) // 2 + 1

    @property
    def leader(self) -> str:
        """Whose turn the present epoch is."""
        return self._turn_of(self.kept.epoch)

    def _turn_of(self, epoch: int) -> str:
        return self._replicas[epoch % len(self._replicas)]

    # --- writing ---------------------------------------------------------------------------------

    def write(self, version: int, reservations: PlaceReservations, removed: AllRemoved = ()) -> None:
        """Send the present table to all replicas. It counts when `counted` reaches `version`."""
        given_back = self._proofs.words()
        self.kept = Kept(self.kept.epoch, self.kept.epoch, version, reservations, removed, given_back)
        self._has = {self._me: version, **{k: v for k, v in self._has.items() if k != self._me}}
        self._led_from = version if self._led_from is None else self._led_from
        self.repeat()
        self._count()

    def note_word(self, atv: str, request: PlaceRequested, *, struck: bool, oldest: int = 0) -> None:
        """Keep a vehicle's request as proof for the replicas that have not copied the resulting table yet.

        Args:
            atv: the vehicle.
            request: what it has said that it holds.
            struck: whether it has struck lines out of the table.
            oldest: the lowest grant number of these lines; 0 when it is unknown.
        """
        if self._others and (struck or self.is_behind):
            self._proofs.note(atv, request, self.kept.version, struck=struck, oldest=oldest)

    def repeat(self) -> None:
        """Send the table to the replicas that have not acknowledged it."""
        kept = self.kept
        for other in self._others:
            has = self._has.get(other, -1)
            if has >= kept.version:
                continue
            replicated = TableReplicated(
                district=self.district,
                epoch=kept.epoch,
                version=kept.version,
                reservations=kept.reservations,
                removed=kept.removed,
                given_back=tuple(
                    GivenBack(atv=atv, request=msgspec.structs.replace(request, avoid=()))
                    for atv, request in self._proofs.needed(has, self._may_have(other))
                ),
            )
            self._life.send(other, replicated)

    def _may_have(self, replica: str) -> int:
        """The highest grant number of the lines that a replica may have copied, also if its acknowledgements are still under way."""
        led_from = self.kept.version if self._led_from is None else self._led_from
        return self._has.get(replica, led_from) + UNDER_WAY_MAX

    @property
    def is_behind(self) -> bool:
        """Whether `me` leads and a replica has not acknowledged the newest version."""
        return self.leads and any(self._has.get(other, -1) < self.kept.version for other in self._others)

    @property
    def is_outvoted(self) -> bool:
        """Whether the newest version of `me` does not count, and a replica follows a later epoch."""
        return (
            self.leads
            and self.counted < self.kept.version
            and any(word > self.kept.epoch for word in self._words.values())
        )

    def on_acknowledged(self, sender: str, kept: TableAcknowledged) -> bool:
        """A replica has acknowledged a copy; True when a later version counts now."""
        self._note(sender, kept.epoch)
        if kept.epoch > self.kept.epoch:
            if self._follows(sender, kept.epoch, silent=False):
                self._step_down(kept.epoch)
            return False
        if not self.leads or kept.epoch < self.kept.epoch:
            return False
        self._has[sender] = max(self._has.get(sender, -1), kept.version)
        self._proofs.drop([(self._has.get(other, -1), self._may_have(other)) for other in self._others])
        return self._count()

    def _count(self) -> bool:
        """Set `counted` to the version that a majority has; True when it has grown."""
        versions = sorted((self._has.get(replica, -1) for replica in self._replicas), reverse=True)
        counted = versions[self.majority - 1]
        if counted <= self.counted:
            return False
        self.counted = counted
        return True

    # --- copies ----------------------------------------------------------------------------------

    def on_replicated(self, sender: str, replicated: TableReplicated, *, silent: bool) -> bool:
        """Copy a table that its leader has written, if it is believed.

        Args:
            sender: the replica that sent it.
            replicated: the table.
            silent: the leader of the present epoch does not answer `me`.

        Returns:
            Whether its epoch is believed.
        """
        joins = self.lost
        if not is_version_believed(replicated.version, self.kept.version):
            self.refused, self.misses = self.refused + 1, ()
            return True
        if joins and not self._may_join(sender, replicated):
            return True
        self.lost = False
        if joins:
            self._began = self._polled = replicated.epoch
        self._note(sender, replicated.epoch)
        follows = joins or self._follows(sender, replicated.epoch, silent=silent)
        if replicated.epoch >= self.kept.epoch and sender != self._me and follows:
            if replicated.epoch > self.kept.epoch:
                self._step_down(replicated.epoch)
            self._sought = 0
            if (replicated.epoch, replicated.version) > (self.kept.kept_epoch, self.kept.version):
                before = self.kept.reservations
                if self._objects(replicated):
                    return follows
                self.kept = Kept(
                    replicated.epoch,
                    replicated.epoch,
                    replicated.version,
                    replicated.reservations,
                    replicated.removed,
                    self.kept.given_back,
                )
                self._elsewhere, self._copied, self.refused, self.misses = None, True, 0, ()
                self._confirm_new(before)
        self._life.send(
            sender,
            TableAcknowledged(district=self.district, epoch=self.kept.epoch, version=self.kept.version),
        )
        return follows

    def _objects(self, replicated: TableReplicated) -> bool:
        """Whether a table must be refused for lines that were struck out."""
        kept, other = self.kept, self._elsewhere
        if not self._copied or self._turn_of(kept.kept_epoch) != self._turn_of(replicated.epoch):
            # Another leader wrote the copy, and its last write may never have counted.
            return False
        if other is not None and kept.kept_epoch < other.began <= replicated.epoch:
            # A recovery poll was started since.
            return False
        self.misses = tuple(self._witness.objections(kept.reservations, kept.version, replicated))
        self.refused += bool(self.misses)
        return bool(self.misses)

    def ask_for_words(self) -> None:
        """Name to the other replicas the releases that are missing here, and ask the vehicles for them.

        The other copy also answers whether a recovery poll was started. A vehicle settles it when leader and witness have both asked.
        """
        own = set(self.kept.reservations)
        missed: dict[tuple[str, bytes], PlaceReservation] = {}
        for line in sorted(self.misses, key=lambda line: line.number):
            if line in own:
                missed[line.atv, line.mark] = line
        asked = TableAsked(district=self.district, epoch=0, misses=tuple(missed.values())[:MISSES_MAX])
        for replica in self._others:
            self._life.send(replica, asked)
        for atv in dict.fromkeys(line.atv for line in self.misses):
            self._ask_vehicle(
                atv, max((line.number for line in missed.values() if line.atv == atv), default=0)
            )

    def on_misses(self, misses: Iterable[PlaceReservation]) -> None:
        """Another replica misses the releases of these lines: ask their vehicles, where the lines are struck out here, too."""
        if self.lost:
            return
        own = {line.place: line for line in self.kept.reservations}
        for line in misses:
            held = own.get(line.place)
            is_held = held is not None and (held.atv, held.mark) == (line.atv, line.mark)
            if line.atv and line.number <= self.kept.version and not is_held:
                self._ask_vehicle(line.atv, line.number)

    def _ask_vehicle(self, atv: str, misses: int) -> None:
        asked = HoldsAsked(district=self.district, epoch=self.kept.epoch, misses=misses or UNSET)
        self._life.send(atv, asked)

    def on_carried(self, atv: str) -> None:
        """A person has carried a vehicle away."""
        self._witness.on_carried(atv, self.kept.version)

    @property
    def is_witness(self) -> bool:
        """Whether vehicles need a confirmation by `me` to believe a grant."""
        return not self.lost and not self.leads and self._turn_of(self.kept.epoch + 1) == self._me

    def note_life(self, atv: str, request: PlaceRequested) -> None:
        """Note the life of a vehicle that has sent a request to `me`."""
        self._witness.note_life(atv, request, self.kept.reservations)

    def confirm(self, atv: str, mark: bytes, seen: int = 0) -> None:
        """Confirm to a vehicle its lines of the copy, and to a life after its first one those under its key.

        Args:
            atv: the vehicle.
            mark: of its key.
            seen: the highest grant number that it says it has seen; 0 when it has not asked.
        """
        if not self.is_witness:
            return
        life = self._witness.life_of(atv, mark)
        names_life = life > FIRST_LIFE
        lines = tuple(
            line
            for line in self.kept.reservations
            if line.atv == atv and (line.mark == mark or not names_life)
        )
        confirmed = PlaceConfirmed(
            district=self.district,
            epoch=self.kept.epoch,
            grants=lines,
            life=life if names_life else UNSET,
            polled=self._polled if self._polled and seen > self.kept.version else UNSET,
        )
        self._life.send(atv, confirmed)

    def _confirm_new(self, before: Iterable[PlaceReservation]) -> None:
        """Confirm to the vehicles their new lines."""
        if self.is_witness:
            known = set(before)
            new = {line.atv: line.mark for line in self.kept.reservations if line not in known}
            for atv, mark in new.items():
                self.confirm(atv, mark)

    def _may_join(self, sender: str, replicated: TableReplicated) -> bool:
        """Whether a table restores a lost memory: its writer was lost, too, and all others have reported no later epoch since.

        Its writer must be the one that polls vehicles, or another replica must follow it. So a liar that is not the first of those
        without memory gets no forged table copied. Nor can a writer alone raise the epoch near the end of numbers.
        """
        polls = next(
            replica for replica in self._replicas if replica == self._me or replica in self._lost_too
        )
        is_followed = any(
            self._words.get(other) == replicated.epoch for other in self._others if other != sender
        )
        known = max((self._heard.get(other, 0) for other in self._others if other != sender), default=0)
        return (
            not self.needs_recovery_poll
            and sender in self._lost_too
            and (sender == polls or is_followed)
            and replicated.epoch <= most_believed(known, LEAP_MAX)
            and all(
                self._heard.get(other, replicated.epoch + 1) <= replicated.epoch for other in self._others
            )
        )

    # --- whose turn ------------------------------------------------------------------------------

    def _note(self, sender: str, epoch: int) -> None:
        self._words[sender] = max(self._words.get(sender, 0), epoch)

    def _follows(self, sender: str, epoch: int, *, silent: bool) -> bool:
        """Whether a later epoch is believed: two replicas report it, or one does, and the present leader is that one or silent."""
        if epoch <= self.kept.epoch:
            return True
        if any(self._words.get(other) == epoch for other in self._others if other != sender):
            return True
        leaps = epoch > self.kept.epoch + LEAP_MAX
        return not leaps and self.leader != self._me and (sender == self.leader or silent)

    def seek(self, absent: Collection[str] = ()) -> None:
        """Seek the leadership, under the next epoch that is this replica's turn.

        Args:
            absent: replicas that do not answer, and are not waited for.
        """
        if self.lost:
            return
        self.leads = False
        self._sought = self.next_turn(self.kept.epoch)
        self._absent, self._rounds, self._told = frozenset(absent), 0, {}
        self.ask()

    def ask(self) -> None:
        """Ask the replicas that have not answered; harmless when there is nothing to ask."""
        if not self._sought and not self.lost:
            return
        self._rounds += 1
        if self._sought and self._rounds > 2 * PATIENT_ROUNDS and self._highest > self._sought:
            # This epoch is too low: a later one is needed.
            self._sought = 0
            return
        for other in self._others:
            if other not in self._told:
                self._life.send(other, TableAsked(district=self.district, epoch=self._sought))
        self._decide()

    @property
    def asks(self) -> bool:
        """Whether it waits for answers of other replicas."""
        return bool(self._sought) or (self.lost and not self.needs_recovery_poll)

    def on_asked(self, sender: str, asked: TableAsked, *, silent: bool) -> bool:
        """A replica seeks the leadership, or asks for the table: answer with the present state.

        Args:
            sender: the replica.
            asked: the epoch that it seeks.
            silent: the leader of the present one does not answer `me`.

        Returns:
            Whether the epoch is promised to it.
        """
        promises = self._replicas[asked.epoch % len(self._replicas)] == sender and self._follows(
            sender, asked.epoch, silent=silent
        )
        if asked.epoch > self.kept.epoch and not self.lost and promises:
            self._step_down(asked.epoch)
        self._life.send(sender, self._telling())
        return promises

    def note_highest(self, epoch: int) -> None:
        """Note a reported epoch for the next turn of `me`, unless others would not follow because it is too high (`OUTBID_MAX`)."""
        if epoch <= self.kept.epoch + OUTBID_MAX:
            self._highest = max(self._highest, epoch)

    def on_reported(self, sender: str, told: TableReported) -> None:
        """A replica has answered a question for its table."""
        self.note_highest(told.epoch)
        self._note(sender, told.epoch)
        self._versions[sender] = max(self._versions.get(sender, 0), told.version)
        if sender != self.leader and not told.lost:
            self._elsewhere = told
        is_promise = bool(self._sought) and told.epoch == self._sought
        if told.epoch > self.kept.epoch and not self.lost and not is_promise:
            if self._follows(sender, told.epoch, silent=False):
                self._step_down(told.epoch)
        if not self.asks:
            return
        if self.lost:
            self._heard[sender] = max(self._heard.get(sender, 0), told.epoch)
            if told.lost:
                self._lost_too.add(sender)
        if self._sought and told.epoch > self._sought:
            # A replica with a later epoch promises nothing; the others may.
            self._absent |= {sender}
            self._decide()
            return
        if self._sought and (told.lost or told.epoch < self._sought):
            # A lost replica gives no promise, and an older epoch does not answer this question.
            if sender == self.leader and not told.lost:
                # The leader lives.
                self._sought = 0
            return
        self._told[sender] = told
        self._decide()

    def _decide(self) -> None:
        """Finish what is sought when enough replicas have answered: lead, recover the memory, or need a recovery poll."""
        if self._sought:
            if len(self._told) + 1 >= self.majority and self._has_heard_enough:
                self._take_newest((self._telling(), *self._told.values()))
                self.kept = msgspec.structs.replace(self.kept, epoch=self._sought)
                self._sought = 0
                self.leads = True
                # `_proofs` stays: requests hold in every epoch, and a replica may not have copied their effect yet.
                self._has, self._led_from = {}, None
                self.counted = 0
        elif self.lost and len(self._told) == len(self._others):
            remember = [told for told in self._told.values() if not told.lost]
            if len(remember) >= self.majority or (remember and len(remember) == len(self._others)):
                self.lost = False
                epoch = highest_believed((told.epoch for told in remember), leap=LEAP_MAX)
                self._take_newest(remember)
                self.kept = msgspec.structs.replace(self.kept, epoch=epoch)
            else:
                lost = {self._me, *(replica for replica, told in self._told.items() if told.lost)}
                self.needs_recovery_poll = (
                    next(replica for replica in self._replicas if replica in lost) == self._me
                )
            self._told = {}

    @property
    def _has_heard_enough(self) -> bool:
        """Whether every awaited replica has answered, or was asked often enough."""
        silent = set(self._others) - self._told.keys() - self._absent
        return not silent or self._rounds > PATIENT_ROUNDS

    def _take_newest(self, told: Iterable[TableReported]) -> None:
        """Take the newest copy. If all have answered, a copy newer than that of `me` must be on two replicas."""
        ranked = sorted(told, key=lambda one: (one.kept_epoch, one.version), reverse=True)
        has_all = len(ranked) == len(self._replicas) > self.majority
        own = (self.kept.kept_epoch, self.kept.version)
        newest = ranked[0]
        if has_all and (newest.kept_epoch, newest.version) > own:
            newest = ranked[1]
        self.kept = Kept(
            self.kept.epoch,
            newest.kept_epoch,
            newest.version,
            newest.reservations,
            newest.removed,
            self.kept.given_back,
        )

    def next_turn(self, epoch: int) -> int:
        """The next epoch of this replica's turns, after `epoch` and all reported ones."""
        # A recovery poll needs an epoch above all remembered ones: a replica that remembers a higher one would never follow.
        remembered = highest_believed(self._heard.values(), leap=LEAP_MAX) if self.needs_recovery_poll else 0
        epoch = max(epoch, self._highest, remembered) + 1
        while self._replicas[epoch % len(self._replicas)] != self._me:
            epoch += 1
        return epoch

    def end_recovery_poll(self, epoch: int) -> int:
        """Lead under an epoch above all reported ones; the table is made from the vehicles' answers.

        Returns:
            The highest version that any replica has reported: numbers of this table are higher.
        """
        self.lost, self.needs_recovery_poll, self.leads = False, False, True
        self._polled = epoch
        self.kept = Kept(epoch, epoch, 0, ())
        self._has, self._led_from, self._proofs, self.counted = {}, None, Proofs(), 0
        return highest_believed(self._versions.values())

    def _telling(self) -> TableReported:
        kept = self.kept
        return TableReported(
            district=self.district,
            epoch=max(kept.epoch, self._sought),
            lost=self.lost,
            kept_epoch=kept.kept_epoch,
            version=kept.version,
            reservations=kept.reservations,
            removed=kept.removed,
            began=self._began,
        )

    def _step_down(self, epoch: int) -> None:
        self.kept = msgspec.structs.replace(self.kept, epoch=epoch)
        self.leads = False
        self._sought = 0
