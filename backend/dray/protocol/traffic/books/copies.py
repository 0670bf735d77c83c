"""One book, kept by several machines: who may write it, and when what is written counts.

Viewstamped replication with a book small enough to be sent whole. Under an *epoch* one keeper alone writes, the one whose turn it is;
it has that epoch from a majority, and learned from them the newest copy that there is. What it writes counts when a majority has it. Whoever
was left behind by a torn network finds no majority any more: traffic in the district waits, and no place is given twice.

A keeper that has lost its memory takes no part until it has heard all others, for it may have promised what it does not know. When too
few remember, the vehicles are asked what they hold (a roll call), every one of them. Another one that has lost its memory, too, and
has heard since that the caller had, takes the caller's book: each vehicle has told under that epoch, and follows no earlier one. It has heard of
no later one from anybody since, so nobody leads by a promise that it has forgotten.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import msgspec

from dray.messages.floor.traffic import AllRemoved, BookAsked, Bookings, BookKept, BookTold, PlaceBooked
from dray.protocol.runtime.events import Effect, Send


class Kept(msgspec.Struct, frozen=True):
    """What a keeper must not forget between two of its lives."""

    epoch: int = 0
    """The highest that it has promised, or heard of."""
    kept_epoch: int = 0
    """Of the one who has written the copy."""
    version: int = 0
    bookings: Bookings = ()
    removed: AllRemoved = ()


class Copies:
    """One keeper's part in keeping the book of a district.

    Args:
        district: whose book.
        me: the keeper.
        keepers: all of them, in the order of their turns; `me` is one of them.
        kept: what an earlier life has left; None when it is lost, or there was none.
        out: where effects go.

    Attributes:
        kept: what must be written down before anything is said.
        leads: whether `me` writes the book under the present epoch.
        counted: the highest version that a majority has.
        lost: whether it knows nothing yet.
        needs_roll_call: too few remember; `me` is to ask the vehicles.
    """

    def __init__(
        self, district: str, me: str, keepers: Sequence[str], kept: Kept | None, out: list[Effect]
    ) -> None:
        self.district = district
        self.kept = kept or Kept()
        self.leads = False
        self.counted = 0
        self.lost = kept is None
        self.needs_roll_call = False
        self._me = me
        self._keepers = tuple(keepers)
        self._others = tuple(keeper for keeper in keepers if keeper != me)
        self._out = out
        self._has: dict[str, int] = {}
        """Districts -> the version that it has under this epoch."""
        self._told: dict[str, BookTold] = {}
        self._highest = 0
        """Epoch that anybody has told of."""
        self._sought = 0
        """The epoch under which `me` asks to keep the book; 0 when it does not."""
        self._heard: dict[str, int] = {}
        """While it is lost: keeper -> the epoch that it has told of."""
        self._lost_too: set[str] = set()
        """While it is lost: those that have told that they were."""

    @property
    def majority(self) -> int:
        return len(self._keepers) // 2 + 1

    @property
    def leader(self) -> str:
        """Whose turn the present epoch is."""
        return self._keepers[self.kept.epoch % len(self._keepers)]

    # --- writing ---------------------------------------------------------------------------------

    def write(self, version: int, bookings: Bookings, removed: AllRemoved = ()) -> None:
        """Let everybody have the book as it is now. It counts when `counted` has come to `version`."""
        self.kept = Kept(self.kept.epoch, self.kept.epoch, version, bookings, removed)
        self._has = {self._me: version, **{k: v for k, v in self._has.items() if k != self._me}}
        self.repeat()
        self._count()

    def repeat(self) -> None:
        """Say it again to those who have not answered."""
        kept = self.kept
        booked = PlaceBooked(
            district=self.district,
            epoch=kept.epoch,
            version=kept.version,
            bookings=kept.bookings,
            removed=kept.removed,
        )
        for other in self._others:
            if self._has.get(other, -1) < kept.version:
                self._out.append(Send(other, booked))

    @property
    def is_behind(self) -> bool:
        """Whether somebody has not answered for the newest version."""
        return self.leads and any(self._has.get(other, -1) < self.kept.version for other in self._others)

    def on_kept(self, sender: str, kept: BookKept) -> bool:
        """A copy was written; True when more counts now."""
        if kept.epoch > self.kept.epoch:
            self._step_down(kept.epoch)
            return False
        if not self.leads or kept.epoch < self.kept.epoch:
            return False
        self._has[sender] = max(self._has.get(sender, -1), kept.version)
        return self._count()

    def _count(self) -> bool:
        """How much a majority has."""
        versions = sorted((self._has.get(keeper, -1) for keeper in self._keepers), reverse=True)
        counted = versions[self.majority - 1]
        if counted <= self.counted:
            return False
        self.counted = counted
        return True

    # --- copies ----------------------------------------------------------------------------------

    def on_booked(self, sender: str, booked: PlaceBooked) -> None:
        """The keeper of the book has written."""
        if self.lost and not self._may_join(sender, booked):
            return
        self.lost = False
        if booked.epoch >= self.kept.epoch and sender != self._me:
            if booked.epoch > self.kept.epoch:
                self._step_down(booked.epoch)
            self._sought = 0
            if (booked.epoch, booked.version) > (self.kept.kept_epoch, self.kept.version):
                self.kept = Kept(booked.epoch, booked.epoch, booked.version, booked.bookings, booked.removed)
        self._out.append(
            Send(sender, BookKept(district=self.district, epoch=self.kept.epoch, version=self.kept.version))
        )

    def _may_join(self, sender: str, booked: PlaceBooked) -> bool:
        """Whether a lost memory is made good by a book: its writer was lost, too, and all have told of no later epoch since."""
        return (
            not self.needs_roll_call
            and sender in self._lost_too
            and all(self._heard.get(other, booked.epoch + 1) <= booked.epoch for other in self._others)
        )

    # --- whose turn ------------------------------------------------------------------------------

    def seek(self) -> None:
        """Ask to keep the book from now on, under the next epoch that is this keeper's turn."""
        if self.lost:
            return
        epoch = self.next_turn(self.kept.epoch)
        self._step_down(epoch)
        self._sought = epoch
        self._told = {self._me: self._telling()}
        self.ask()

    def ask(self) -> None:
        """Ask those who have not told; harmless when there is nothing to ask."""
        if not self._sought and not self.lost:
            return
        for other in self._others:
            if other not in self._told:
                self._out.append(Send(other, BookAsked(district=self.district, epoch=self._sought)))
        self._decide()

    @property
    def asks(self) -> bool:
        """Whether it waits for what others tell."""
        return bool(self._sought) or (self.lost and not self.needs_roll_call)

    def on_asked(self, sender: str, asked: BookAsked) -> None:
        """Somebody wants to keep the book, or to know it."""
        if asked.epoch > self.kept.epoch and not self.lost:
            self._step_down(asked.epoch)
        self._out.append(Send(sender, self._telling()))

    def on_told(self, sender: str, told: BookTold) -> None:
        """Somebody has answered."""
        self._highest = max(self._highest, told.epoch)
        if not self.asks:
            return
        if self.lost:
            self._heard[sender] = max(self._heard.get(sender, 0), told.epoch)
            if told.lost:
                self._lost_too.add(sender)
        if self._sought and told.epoch > self._sought:
            self._step_down(told.epoch)
            return
        if self._sought and (told.lost or told.epoch < self._sought):
            # Whoever knows nothing gives no promise; an older answer was none to this question.
            return
        self._told[sender] = told
        self._decide()

    def _decide(self) -> None:
        """Whether enough have told."""
        if self._sought:
            if len(self._told) >= self.majority:
                self._take_newest(self._told.values())
                self._sought = 0
                self.leads = True
                self._has = {}
                self.counted = 0
        elif self.lost and len(self._told) == len(self._others):
            remember = [told for told in self._told.values() if not told.lost]
            if len(remember) >= self.majority or (remember and len(remember) == len(self._others)):
                self.lost = False
                epoch = max(told.epoch for told in remember)
                self._take_newest(remember)
                self.kept = msgspec.structs.replace(self.kept, epoch=epoch)
            else:
                lost = {self._me, *(keeper for keeper, told in self._told.items() if told.lost)}
                self.needs_roll_call = next(keeper for keeper in self._keepers if keeper in lost) == self._me
            self._told = {}

    def _take_newest(self, told: Iterable[BookTold]) -> None:
        newest = max(told, key=lambda one: (one.kept_epoch, one.version))
        self.kept = Kept(self.kept.epoch, newest.kept_epoch, newest.version, newest.bookings, newest.removed)

    def next_turn(self, epoch: int) -> int:
        """The next epoch after one, and after all that anybody has told of, that is this keeper's turn."""
        epoch = max(epoch, self._highest) + 1
        while self._keepers[epoch % len(self._keepers)] != self._me:
            epoch += 1
        return epoch

    def end_roll_call(self, epoch: int) -> None:
        """Lead under an epoch above all that anybody has told of; the book is made of what the vehicles have told."""
        self.lost, self.needs_roll_call, self.leads = False, False, True
        self.kept = Kept(epoch, epoch, 0, ())
        self._has, self.counted = {}, 0

    def _telling(self) -> BookTold:
        kept = self.kept
        return BookTold(
            district=self.district,
            epoch=kept.epoch,
            lost=self.lost,
            kept_epoch=kept.kept_epoch,
            version=kept.version,
            bookings=kept.bookings,
            removed=kept.removed,
        )

    def _step_down(self, epoch: int) -> None:
        self.kept = msgspec.structs.replace(self.kept, epoch=epoch)
        self.leads = False
        self._sought = 0
