"""What makes a grant believable: the epoch that a majority of a table's replicas have reported, and the lines that the witness has confirmed.

The *witness* is the replica whose turn is next. It confirms each line that it has copied. A grant without confirmation is believed only
when the witness does not answer. So no replica alone gives a place twice.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

from msgspec import UNSET

from dray.messages.floor.traffic import FIRST_LIFE, PlaceConfirmed, PlaceGranted

NO_EPOCH = -1
"""The epoch before the first one."""

WITNESS_ASKED = 4
"""Unanswered questions after which the witness counts as silent: at 20 % loss each way, 1 of 60 living ones."""


class Evidence:
    """What one vehicle has been told about one table by its replicas.

    Args:
        replicas: of the table, in the order of their turns.
        life: the vehicle's: number of starts of its agent.

    Attributes:
        agreed: the latest epoch that a majority of the replicas have reported.
        unbelieved: sender and answer: the newest one that is not believed yet; None for none.
        witness_asked: questions to the witness since it was last heard.
    """

    __slots__ = (
        "_before_poll",
        "_confirmed",
        "_confirmed_epoch",
        "_copy_poll",
        "_early",
        "_life",
        "_missed_releases",
        "_replicas",
        "_reported",
        "agreed",
        "unbelieved",
        "witness_asked",
    )

    def __init__(self, replicas: Sequence[str], life: int) -> None:
        self._replicas, self._life = replicas, life
        self.agreed = NO_EPOCH
        self.unbelieved: tuple[str, PlaceGranted] | None = None
        self.witness_asked = 0
        self._reported: dict[str, int] = {}
        """Replica -> the latest epoch that it has reported."""
        self._before_poll: int | None = None
        """`agreed` when the last recovery poll asked; None once a table made since has answered with grants."""
        self._confirmed: dict[str, int] = {}
        """Place -> number of the grant, as the witness of `_confirmed_epoch` has it."""
        self._confirmed_epoch = NO_EPOCH
        self._copy_poll = NO_EPOCH
        """Epoch of the recovery poll from whose table that witness has its copy, as it has told; else `NO_EPOCH`."""
        self._early: PlaceConfirmed | None = None
        """The witness's newest confirmation under an epoch that was not agreed."""
        self._missed_releases: dict[str, tuple[int, int]] = {}
        """Replica -> epoch and number of its newest question for a release that a copy misses (`HoldsAsked.misses`)."""

    def leader(self, epoch: int) -> str:
        """The replica that grants under an epoch."""
        return self._replicas[epoch % len(self._replicas)]

    def witness(self, epoch: int) -> str:
        """The replica that confirms the leader's grants under an epoch."""
        return self._replicas[(epoch + 1) % len(self._replicas)]

    # --- what the replicas tell ---

    def is_agreed(self, sender: str, epoch: int) -> bool:
        """Note an epoch that a replica reports; whether it is the one that a majority have reported."""
        if epoch > self.agreed:
            self._report(sender, epoch)
            alike = sum(reported == epoch for reported in self._reported.values())
            if alike > len(self._replicas) // 2:
                self.agreed = epoch
        return epoch == self.agreed

    def on_poll(self, sender: str, epoch: int) -> None:
        """A recovery poll asks: the table that it makes may begin with lower numbers."""
        self._report(sender, epoch)
        self._before_poll = self.agreed
        self._missed_releases.clear()

    def on_confirmed(self, sender: str, confirmed: PlaceConfirmed, mark: bytes) -> bool:
        """Note the witness's confirmation of the lines that it has copied; False when it is refused.

        Args:
            sender: who has sent it.
            confirmed: the confirmation.
            mark: of the vehicle's key; empty before its first request.
        """
        if self.witness(confirmed.epoch) != sender or confirmed.epoch < self._confirmed_epoch:
            return False
        is_agreed = self.is_agreed(sender, confirmed.epoch)
        if not self._is_to_this_life(confirmed, mark):
            return True
        if is_agreed:
            self._take(confirmed, mark)
        else:
            self._early = confirmed
        return True

    def on_release_missed(self, sender: str, epoch: int, number: int) -> None:
        """A replica asks for a release, below this number, that a copy misses."""
        self._missed_releases[sender] = epoch, number

    # --- what follows from it ---

    @property
    def waits_for_witness(self) -> bool:
        """Whether the unbelieved answer lacks its confirmation alone."""
        return self.unbelieved is not None and self.unbelieved[1].epoch == self.agreed

    def is_confirmed(self, granted: PlaceGranted, mark: bytes, seen: int, since: int) -> bool:
        """Whether the witness has confirmed all new lines of an answer, or is silent.

        Args:
            granted: the answer.
            mark: of the vehicle's key.
            seen: the highest number that the vehicle has seen.
            since: the request from which on the table of a recovery poll answers.
        """
        if len(self._replicas) == 1 or self.witness_asked > WITNESS_ASKED:
            return True
        early = self._early
        if early is not None and early.epoch == granted.epoch and self._is_to_this_life(early, mark):
            self._take(early, mark)
        is_of_its_epoch = self._confirmed_epoch == granted.epoch
        if self._begins_lower(granted, seen, since):
            if not is_of_its_epoch or self._copy_poll <= (self._before_poll or 0):
                # A leader alone may have asked as if in a recovery poll, to have an old line taken for a new grant.
                return False
            seen = 0
        known = self._confirmed if is_of_its_epoch else {}
        return all(
            known.get(reservation.place) == reservation.number
            for reservation in granted.grants
            if reservation.number > seen
        )

    def accept(self, granted: PlaceGranted, seen: int, since: int) -> int:
        """Note a believed answer. Returns the highest number seen, which is void after a recovery poll."""
        self.unbelieved = None
        if not self._is_of_new_table(granted, since):
            return seen
        seen = 0 if self._begins_lower(granted, seen, since) else seen
        self._before_poll = None
        self._missed_releases.clear()
        return seen

    def number_to_settle(self) -> int:
        """The number below which a copy misses a release, as leader and witness have told under the agreed epoch; 0 for none.

        One of the two is honest, and numbers no later grant so low.
        """
        told = [
            self._missed_releases.get(replica, (NO_EPOCH, 0))
            for replica in (self.leader(self.agreed), self.witness(self.agreed))
        ]
        is_told_now = all(epoch == self.agreed for epoch, _ in told)
        return max(0, min(number for _, number in told)) if is_told_now else 0

    def forget_released(self, seen: int, holds: Collection[str]) -> None:
        """Forget the confirmed lines up to a number, of places that the vehicle does not hold."""
        for place in [one for one, number in self._confirmed.items() if number <= seen and one not in holds]:
            del self._confirmed[place]

    # --- internals ---

    def _report(self, sender: str, epoch: int) -> None:
        self._reported[sender] = max(self._reported.get(sender, 0), epoch)

    def _is_to_this_life(self, confirmed: PlaceConfirmed, mark: bytes) -> bool:
        """Whether the witness has confirmed to this life. Otherwise it may still believe an earlier life's release of these lines."""
        return confirmed.life == self._life or self._life <= FIRST_LIFE or not mark

    def _take(self, confirmed: PlaceConfirmed, mark: bytes) -> None:
        if confirmed.epoch != self._confirmed_epoch:
            self._copy_poll = NO_EPOCH
        self._early, self.witness_asked, self._confirmed_epoch = None, 0, confirmed.epoch
        if confirmed.polled is not UNSET:
            self._copy_poll = confirmed.polled
        self._confirmed = {one.place: one.number for one in confirmed.grants if one.mark == mark}

    def _is_of_new_table(self, granted: PlaceGranted, since: int) -> bool:
        """Whether an answer under the agreed epoch is the first one with grants since the vehicle has answered a recovery poll."""
        before = self._before_poll
        return (
            before is not None and granted.epoch > before and granted.upto >= since and bool(granted.grants)
        )

    def _begins_lower(self, granted: PlaceGranted, seen: int, since: int) -> bool:
        """Whether the table of an answer begins below what the vehicle has seen: then that is void."""
        return (
            self._is_of_new_table(granted, since)
            and max(reservation.number for reservation in granted.grants) < seen
        )
