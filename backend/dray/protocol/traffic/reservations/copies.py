"""One reservation table, kept by several machines: who may write it, and when what is written counts.

Viewstamped replication with a reservation table small enough to be sent whole. Under an *epoch* one replica alone writes, the one whose turn it is;
it has that epoch from a majority, and learned from them the newest copy that there is. What it writes counts when a majority has it. Whoever
was left behind by a torn network finds no majority any more: traffic in the district waits, and no place is given twice.

Nobody takes an epoch by saying so. A replica follows a later one when the leader of the present one begins it, when two others have told the
same one, or when the leader of the present one does not answer *it* either. So whoever has stolen the certificate of one replica writes over
none that lives. A replica that waits for the promises of others promises nothing meanwhile: it goes on with the present one when that one answers.

Nor does the one that leads write what it likes: nobody copies a reservation table that takes a place from a vehicle without its word (`witness`), and the
replica whose turn is next confirms to each vehicle what it has copied. So two replicas would have to lie to give a place twice.

A replica that has lost its memory takes no part until it has heard all others, for it may have promised what it does not know. When too
few remember, the vehicles are asked what they hold (a recovery poll), every one of them. Another one that has lost its memory, too, and
has heard since that the caller had, takes the caller's reservation table: each vehicle has told under that epoch, and follows no earlier one. It has heard of
no later one from anybody since, so nobody leads by a promise that it has forgotten.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence

import msgspec

from dray.messages.floor.traffic import (
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
from dray.protocol.traffic.reservations.witness import Witness
from dray.protocol.traffic.traffic_map import IsSigned, names_no_key

PATIENT_ROUNDS = 2
"""So often all others are asked before the answers of a majority are enough: what one has, the other must have, too."""


class Kept(msgspec.Struct, frozen=True):
    """What a replica must not forget between two of its lives."""

    epoch: int = 0
    """The highest that it has promised, or heard of."""
    kept_epoch: int = 0
    """Of the one who has written the copy."""
    version: int = 0
    reservations: PlaceReservations = ()
    removed: AllRemoved = ()


class Copies:
    """One replica's part in keeping the table of a district.

    Args:
        district: whose reservation table.
        me: the replica.
        replicas: all of them, in the order of their turns; `me` is one of them.
        kept: what an earlier life has left; None when it is lost, or there was none.
        is_signed: whether a vehicle's request is signed by the key that it names.

    Attributes:
        kept: what must be written down before anything is said.
        leads: whether `me` writes the table under the present epoch.
        counted: the highest version that a majority has.
        lost: whether it knows nothing yet.
        refused: tables of the one that leads that were not copied, since one was.
        needs_recovery_poll: too few remember; `me` is to ask the vehicles.
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
        self.needs_recovery_poll = False
        self._me = me
        self._replicas = tuple(replicas)
        self._others = tuple(replica for replica in replicas if replica != me)
        self._life = life
        self._has: dict[str, int] = {}
        """Replica -> the version that it has under this epoch."""
        self._witness = Witness(district, is_signed)
        self._given_back: dict[str, tuple[int, PlaceRequested]] = {}
        """Vehicle -> its word by which lines were struck out while `me` led, and the first version without them. Kept until all have that version."""
        self._copied = False
        """It has copied a reservation table in this life: what is written from then on is examined."""
        self._began = 0
        self._elsewhere: TableReported | None = None
        """What the other copy has told last, while a reservation table is not copied."""
        self._versions: dict[str, int] = {}
        """Replica -> the highest version that it has told."""
        self._told: dict[str, TableReported] = {}
        self._highest = 0
        """Epoch that anybody has told of."""
        self._words: dict[str, int] = {}
        """Replica -> the highest epoch that it has told to be the present one."""
        self._sought = 0
        """The epoch under which `me` asks to keep the table; 0 when it does not."""
        self._absent: frozenset[str] = frozenset()
        """Those who are not waited for."""
        self._rounds = 0
        """How often the others were asked for their promises."""
        self._heard: dict[str, int] = {}
        """While it is lost: replica -> the epoch that it has told of."""
        self._lost_too: set[str] = set()
        """While it is lost: those that have told that they were."""

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
        """Let everybody have the table as it is now. It counts when `counted` has come to `version`."""
        self.kept = Kept(self.kept.epoch, self.kept.epoch, version, reservations, removed)
        self._has = {self._me: version, **{k: v for k, v in self._has.items() if k != self._me}}
        self.repeat()
        self._count()

    def note_word(self, atv: str, request: PlaceRequested, *, struck: bool) -> None:
        """A vehicle has said what it holds: those who copy what is written next, or have not copied what was written last, must see that.

        Args:
            atv: the vehicle.
            request: its word.
            struck: lines were struck out of the table by it.
        """
        version, before = self._given_back.get(atv, (0, None))
        if not request.mark or not (struck or self.is_behind):
            return
        if before is None or (request.seen >= before.seen if request.mark == before.mark else struck):
            self._given_back[atv] = (max(version, self.kept.version + struck), request)

    def repeat(self) -> None:
        """Say it again to those who have not answered."""
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
                    for atv, (version, request) in self._given_back.items()
                    if version > has
                ),
            )
            self._life.send(other, replicated)

    @property
    def is_behind(self) -> bool:
        """Whether somebody has not answered for the newest version."""
        return self.leads and any(self._has.get(other, -1) < self.kept.version for other in self._others)

    @property
    def is_outvoted(self) -> bool:
        """Whether what `me` writes does not count, and somebody goes by a later epoch, which nobody else has told."""
        return (
            self.leads
            and self.counted < self.kept.version
            and any(word > self.kept.epoch for word in self._words.values())
        )

    def on_acknowledged(self, sender: str, kept: TableAcknowledged) -> bool:
        """A copy was written; True when more counts now."""
        self._note(sender, kept.epoch)
        if kept.epoch > self.kept.epoch:
            if self._follows(sender, kept.epoch, silent=False):
                self._step_down(kept.epoch)
            return False
        if not self.leads or kept.epoch < self.kept.epoch:
            return False
        self._has[sender] = max(self._has.get(sender, -1), kept.version)
        copied = min(self._has.get(other, -1) for other in self._others)
        self._given_back = {atv: word for atv, word in self._given_back.items() if word[0] > copied}
        return self._count()

    def _count(self) -> bool:
        """How much a majority has."""
        versions = sorted((self._has.get(replica, -1) for replica in self._replicas), reverse=True)
        counted = versions[self.majority - 1]
        if counted <= self.counted:
            return False
        self.counted = counted
        return True

    # --- copies ----------------------------------------------------------------------------------

    def on_replicated(self, sender: str, replicated: TableReplicated, *, silent: bool) -> bool:
        """The leader of the table has written.

        Args:
            sender: who says so.
            replicated: the table.
            silent: the leader of the present epoch does not answer `me`.

        Returns:
            Whether its epoch is believed.
        """
        joins = self.lost
        if not is_version_believed(replicated.version, self.kept.version):
            self.refused += 1
            return True
        if joins and not self._may_join(sender, replicated):
            return True
        self.lost = False
        self._began = replicated.epoch if joins else self._began
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
                )
                self._elsewhere, self._copied, self.refused = None, True, 0
                self._confirm_new(before)
        self._life.send(
            sender,
            TableAcknowledged(district=self.district, epoch=self.kept.epoch, version=self.kept.version),
        )
        return follows

    def _objects(self, replicated: TableReplicated) -> bool:
        """Whether a reservation table cannot be copied, for what was struck out of it; then the other copy is asked, and the vehicles."""
        kept, other = self.kept, self._elsewhere
        if not self._copied or self._turn_of(kept.kept_epoch) != self._turn_of(replicated.epoch):
            # Another one has kept the table before, and perhaps what was written last did not count.
            return False
        if other is not None and kept.kept_epoch < other.began <= replicated.epoch:
            # A recovery poll was started since.
            return False
        objections = self._witness.objections(kept.reservations, kept.version, replicated)
        if not objections:
            return False
        self.refused += 1
        asked = TableAsked(district=self.district, epoch=0)
        for replica in self._others:
            if replica != self._turn_of(replicated.epoch):
                self._life.send(replica, asked)
        holds = HoldsAsked(district=self.district, epoch=replicated.epoch)
        for atv in dict.fromkeys(line.atv for line in objections):
            self._life.send(atv, holds)
        return True

    def on_carried(self, atv: str) -> None:
        """A person has said that a vehicle was carried away."""
        self._witness.on_carried(atv, self.kept.version)

    @property
    def is_witness(self) -> bool:
        """Whether no grant is believed without the word of `me`."""
        return not self.lost and not self.leads and self._turn_of(self.kept.epoch + 1) == self._me

    def confirm(self, atv: str) -> None:
        """Tell a vehicle its lines of the copy."""
        if not self.is_witness:
            return
        lines = tuple(line for line in self.kept.reservations if line.atv == atv)
        self._life.send(atv, PlaceConfirmed(district=self.district, epoch=self.kept.epoch, grants=lines))

    def _confirm_new(self, before: Iterable[PlaceReservation]) -> None:
        """Tell the vehicles of their new lines."""
        if self.is_witness:
            known = set(before)
            for atv in dict.fromkeys(line.atv for line in self.kept.reservations if line not in known):
                self.confirm(atv)

    def _may_join(self, sender: str, replicated: TableReplicated) -> bool:
        """Whether a lost memory is made good by a reservation table: its writer was lost, too, and all have told of no later epoch since.

        Nor does its writer alone bring the epoch near the end of numbers.
        """
        known = max((self._heard.get(other, 0) for other in self._others if other != sender), default=0)
        return (
            not self.needs_recovery_poll
            and sender in self._lost_too
            and replicated.epoch <= most_believed(known, LEAP_MAX)
            and all(
                self._heard.get(other, replicated.epoch + 1) <= replicated.epoch for other in self._others
            )
        )

    # --- whose turn ------------------------------------------------------------------------------

    def _note(self, sender: str, epoch: int) -> None:
        self._words[sender] = max(self._words.get(sender, 0), epoch)

    def _follows(self, sender: str, epoch: int, *, silent: bool) -> bool:
        """Whether a later epoch that one replica tells is believed. It needs two, but where the leader of the present one says so or is silent."""
        if epoch <= self.kept.epoch:
            return True
        if any(self._words.get(other) == epoch for other in self._others if other != sender):
            return True
        leaps = epoch > self.kept.epoch + LEAP_MAX
        return not leaps and self.leader != self._me and (sender == self.leader or silent)

    def seek(self, absent: Collection[str] = ()) -> None:
        """Ask to keep the table from now on, under the next epoch that is this replica's turn.

        Args:
            absent: who does not answer, and is not waited for.
        """
        if self.lost:
            return
        self.leads = False
        self._sought = self.next_turn(self.kept.epoch)
        self._absent, self._rounds, self._told = frozenset(absent), 0, {}
        self.ask()

    def ask(self) -> None:
        """Ask those who have not told; harmless when there is nothing to ask."""
        if not self._sought and not self.lost:
            return
        self._rounds += 1
        if self._sought and self._rounds > 2 * PATIENT_ROUNDS and self._highest > self._sought:
            # It will have to be a later one.
            self._sought = 0
            return
        for other in self._others:
            if other not in self._told:
                self._life.send(other, TableAsked(district=self.district, epoch=self._sought))
        self._decide()

    @property
    def asks(self) -> bool:
        """Whether it waits for what others tell."""
        return bool(self._sought) or (self.lost and not self.needs_recovery_poll)

    def on_asked(self, sender: str, asked: TableAsked, *, silent: bool) -> bool:
        """Somebody wants to keep the table, or to know it.

        Args:
            sender: who.
            asked: under which epoch.
            silent: the leader of the present one does not answer `me`.

        Returns:
            Whether it is promised what it wants.
        """
        promises = self._replicas[asked.epoch % len(self._replicas)] == sender and self._follows(
            sender, asked.epoch, silent=silent
        )
        if asked.epoch > self.kept.epoch and not self.lost and promises:
            self._step_down(asked.epoch)
        self._life.send(sender, self._telling())
        return promises

    def note_highest(self, epoch: int) -> None:
        """Somebody has told of an epoch: the next turn of `me` is later, but never so much later that others do not follow."""
        if epoch <= self.kept.epoch + OUTBID_MAX:
            self._highest = max(self._highest, epoch)

    def on_reported(self, sender: str, told: TableReported) -> None:
        """Somebody has answered."""
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
            # One that goes by a later epoch promises nothing; the others may.
            self._absent |= {sender}
            self._decide()
            return
        if self._sought and (told.lost or told.epoch < self._sought):
            # Whoever knows nothing gives no promise; an older answer was none to this question.
            if sender == self.leader and not told.lost:
                # It lives.
                self._sought = 0
            return
        self._told[sender] = told
        self._decide()

    def _decide(self) -> None:
        """Whether enough have told."""
        if self._sought:
            if len(self._told) + 1 >= self.majority and self._has_heard_enough:
                self._take_newest((self._telling(), *self._told.values()))
                self.kept = msgspec.structs.replace(self.kept, epoch=self._sought)
                self._sought = 0
                self.leads = True
                # Words stay true in every epoch, and perhaps somebody has not copied what was written by them.
                self._has = {}
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
        """Whether everybody has told who is waited for."""
        silent = set(self._others) - self._told.keys() - self._absent
        return not silent or self._rounds > PATIENT_ROUNDS

    def _take_newest(self, told: Iterable[TableReported]) -> None:
        """Of what all replicas have, take what two of three have at least, and of less the newest: `me` comes first, and believes itself."""
        ranked = sorted(told, key=lambda one: (one.kept_epoch, one.version), reverse=True)
        has_all = len(ranked) == len(self._replicas) > self.majority
        own = (self.kept.kept_epoch, self.kept.version)
        newest = ranked[0]
        if has_all and (newest.kept_epoch, newest.version) > own:
            newest = ranked[1]
        self.kept = Kept(
            self.kept.epoch, newest.kept_epoch, newest.version, newest.reservations, newest.removed
        )

    def next_turn(self, epoch: int) -> int:
        """The next epoch after one, and after all that anybody has told of, that is this replica's turn."""
        # A recovery poll runs under an epoch above that of whoever remembers one: else it would never follow.
        remembered = highest_believed(self._heard.values(), leap=LEAP_MAX) if self.needs_recovery_poll else 0
        epoch = max(epoch, self._highest, remembered) + 1
        while self._replicas[epoch % len(self._replicas)] != self._me:
            epoch += 1
        return epoch

    def end_recovery_poll(self, epoch: int) -> int:
        """Lead under an epoch above all that anybody has told of; the table is made of what the vehicles have told.

        Returns:
            The highest version that anybody has told of: numbers of this table are higher.
        """
        self.lost, self.needs_recovery_poll, self.leads = False, False, True
        self.kept = Kept(epoch, epoch, 0, ())
        self._has, self._given_back, self.counted = {}, {}, 0
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
