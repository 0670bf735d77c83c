"""What a vehicle says to the replicas of reservation tables: its whole state in each district, repeated until it is answered.

A vehicle goes by the epoch that a majority of the replicas have told it, and believes no grant of another one. As long as one replica alone has
told of a later epoch, the vehicle sends its request to all of them: those that keep copies answer with the epoch.

Nor does it believe the leader of the table alone: the *witness*, whose turn is next, confirms each line that it has copied. Only where that one
does not answer is a grant believed without its word.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

import msgspec

from dray.messages.floor.traffic import (
    UNSIGNED,
    Blocked,
    HoldsAsked,
    PlaceConfirmed,
    PlaceGranted,
    PlaceRequested,
    Rank,
)
from dray.protocol.runtime.life import Life
from dray.protocol.traffic.numbers import OUTBID_MAX

REQUEST_AGAIN = "request again"

LEAST_AGAIN_S, MOST_AGAIN_S, MOST_ROUNDS = 0.6, 8.0, 1.5
"""Within these an answer is waited for: twice as long as answers take and a little more, doubled with each repetition. On a link on
which they take longer than the most, so many of its round trips."""

WAITS_AGAIN_S, LOSSY_AGAIN_S = 3.0, 1.5
"""A request that was answered and not granted is said again after this: the word that grants it may have been lost. The shorter
one holds where more than `LOSSY_FRAC` of the requests went unanswered at first."""

LOSSY_FRAC = 0.05

NEXT_REPLICA_AFTER = 2
"""So often a request is said to one replica without an answer, then to the next one."""

REPEATS_KEPT = 8
"""Repetitions of one request of which it is known when they were said: an answer to an older one is later than any link explains."""

FIRST_ROUND_S = 0.3
"""How long an answer takes, as long as none has come."""

GAIN, LATE_GAIN = 0.2, 0.5
"""Weight of the newest round trip; and of one in which the request was said again before its answer came: what is believed is too
short then. What a repetition has answered tells nothing: its request was lost, or its replica could not answer yet."""

LATE_IN_ROW = 3
"""So many of these in a row are the link's doing, and not that of one replica that has just begun, or has taken a reservation table over."""

WITNESS_ASKED = 4
"""So often the witness is asked for its word without an answer: at 20 % loss each way one of 60 that live."""

NO_EPOCH = -1
"""Before the first one."""

LOSS_GAIN = 0.05
"""Weight of the newest request, in the part of those that went unanswered."""


Sign = Callable[[PlaceRequested], PlaceRequested]
"""Returns the same request with the vehicle's key and signature."""


def unsigned(request: PlaceRequested) -> PlaceRequested:
    """By a vehicle without a key: whoever has its name speaks for its places."""
    return request


class State(msgspec.Struct, frozen=True, gc=False):
    """What all requests of one moment have in common."""

    rank: Rank
    stands: bool
    docked: bool
    avoid: tuple[str, ...]
    chain: tuple[str, ...]
    removal: int = 0
    asks: bool = False
    """It asks for where it stands, and does not count that among what it holds: a request gives nothing back then where that is asked for."""


class _Line:
    """The correspondence about one district."""

    __slots__ = (
        "agreed",
        "asked_all",
        "asks",
        "confirmed",
        "confirmed_epoch",
        "content",
        "early",
        "epoch",
        "groups",
        "hindered",
        "lives",
        "missed",
        "repeats_s",
        "request",
        "rolled",
        "rolled_after",
        "said_s",
        "seen",
        "seq",
        "since",
        "tries",
        "turn",
        "unanswered",
        "witness_asked",
        "words",
    )

    def __init__(self) -> None:
        self.seq = 0
        self.since = 0
        """The first request that said what was said last."""
        self.seen = 0
        self.epoch = 0
        """Of the table; answers under an earlier one are not believed. It may be later than `agreed` while a recovery poll runs."""
        self.agreed = NO_EPOCH
        """The latest that a majority of the replicas have told."""
        self.words: dict[str, int] = {}
        """Replica -> the latest epoch that it has told."""
        self.request: PlaceRequested | None = None
        """What was said last, as it was said."""
        self.asked_all = False
        """It was said to all replicas."""
        self.missed: tuple[str, PlaceGranted] | None = None
        """The newest answer under an epoch that was not agreed, or that was not confirmed, and who has given it."""
        self.asks = False
        """What was said last asks for where the vehicle stands."""
        self.confirmed: dict[str, int] = {}
        """Place -> number of the grant, as the witness has it."""
        self.rolled_after: int | None = None
        """The epoch that was agreed when a recovery poll was started last; None once a reservation table that was begun since has told of grants."""
        self.confirmed_epoch = NO_EPOCH
        self.early: PlaceConfirmed | None = None
        """The witness's newest word under an epoch that was not agreed."""
        self.witness_asked = 0
        """How often it was asked since it was heard last."""
        self.content: object = None
        """What was said last; None when it must be said anew whatever it is."""
        self.groups: tuple[tuple[str, ...], ...] = ()
        self.unanswered = False
        self.hindered = False
        """It was answered, and not all was granted."""
        self.tries = 0
        self.turn = 0
        """By how many replicas it has gone on from the one whose epoch it is."""
        self.said_s = 0.0
        self.repeats_s: dict[int, float] = {}
        """The first request that said what was said last, and its repetitions -> when: an answer names the one that it answers."""
        self.rolled = (NO_EPOCH, 0)
        """The latest epoch under which it has answered a recovery poll, and the number of its newest answer to one."""
        self.lives = False
        """The replica knows of something that is held, or wanted."""

    def note_new_table(self, granted: PlaceGranted) -> None:
        """A reservation table has answered under an epoch that is agreed. The first one after a recovery poll may count from below what was seen before: that is void."""
        after, (_, answer) = self.rolled_after, self.rolled
        if (
            after is None
            or granted.epoch <= after
            or granted.upto < max(answer, self.since)
            or not granted.grants
        ):
            return
        self.rolled_after = None
        if max(reservation.number for reservation in granted.grants) < self.seen:
            self.seen = 0


class PlaceRequests:
    """The correspondence of one vehicle with the replicas of all districts.

    Args:
        incarnation: how often the vehicle's agent was started.
        replicas_of: district -> its replicas, in the order of their turns.
        sign: signs what it says.

    Attributes:
        round_s: how long an answer takes: two messages and the copies.
    """

    def __init__(
        self, incarnation: int, replicas_of: Mapping[str, Sequence[str]], life: Life, sign: Sign = unsigned
    ) -> None:
        self.life = incarnation
        self._sign = sign
        self._mark = b""
        """That of its key, as it has said last."""
        self._replicas_of = replicas_of
        self._life = life
        self._lines: dict[str, _Line] = {}
        self.round_s = FIRST_ROUND_S
        self._lost_frac = 0.0
        self._late = 0
        """Requests in a row of which the answer came when they had been said again."""

    @property
    def districts(self) -> Iterable[str]:
        """Those whose replicas know of something that is held, or wanted."""
        return [district for district, line in self._lines.items() if line.lives]

    def open(self, district: str) -> None:
        """Have the leader of a district told at the next occasion, whatever there is to tell."""
        self._lines.setdefault(district, _Line()).lives = True

    def groups(self, district: str) -> tuple[tuple[str, ...], ...]:
        """What was asked for last."""
        line = self._lines.get(district)
        return line.groups if line is not None else ()

    def say(
        self,
        district: str,
        holds: tuple[str, ...],
        groups: tuple[tuple[str, ...], ...],
        state: State,
        now_s: float,
        *,
        anew: bool = False,
        to: str = "",
        epoch: int = NO_EPOCH,
    ) -> None:
        """Say how things stand, unless that is known already.

        Args:
            district: whose replica is to know.
            holds: what it holds there.
            groups: what it wants there, one group after the other.
            state: what all its requests have in common.
            now_s: the time.
            anew: also when it is known.
            to: who has asked; empty for the leader of the table.
            epoch: under which a recovery poll was started that this answers.
        """
        line = self._lines.get(district)
        if line is None:
            if not holds and not groups and not anew:
                return
            line = self._lines[district] = _Line()
        content = _content(holds, groups, state)
        if line.content == content and not anew:
            return
        line.content, line.groups = content, groups
        line.tries, line.turn, line.since = 0, 0, line.seq + 1
        line.repeats_s.clear()
        self._send(district, line, holds, groups, state, now_s, to, epoch)

    def repeat(
        self,
        district: str,
        holds: tuple[str, ...],
        groups: tuple[tuple[str, ...], ...],
        state: State,
        now_s: float,
    ) -> None:
        """The alarm has come: no answer, or one that has not granted all."""
        line = self._lines[district]
        if line.missed is not None and line.missed[1].epoch == line.agreed:
            # Perhaps it was forged: the leader of the table is asked again, too.
            line.witness_asked += 1
        elif line.unanswered:
            self._lost_frac += LOSS_GAIN * (1.0 - self._lost_frac)
            line.tries += 1
            if line.tries >= NEXT_REPLICA_AFTER:
                line.tries = 0
                line.turn += 1
        elif not line.hindered or not groups:
            return
        content = _content(holds, groups, state)
        if content != line.content or not line.unanswered:
            line.since = line.seq + 1
            line.repeats_s.clear()
        line.content, line.groups = content, groups
        self._send(district, line, holds, groups, state, now_s)
        if line.missed is not None and line.missed[1].epoch == line.agreed and line.request is not None:
            line.asked_all = True
            self._life.send(_witness(self._replicas_of[district], line.agreed), line.request)

    def _send(
        self,
        district: str,
        line: _Line,
        holds: tuple[str, ...],
        groups: tuple[tuple[str, ...], ...],
        state: State,
        now_s: float,
        to: str = "",
        epoch: int = NO_EPOCH,
    ) -> None:
        replicas = self._replicas_of[district]
        line.seq += 1
        lives = bool(holds or groups)
        # Who runs the recovery poll asks again if this is lost: whoever has nothing there waits for no answer.
        waits = lives or line.unanswered or not to
        line.unanswered, line.said_s, line.lives = waits, now_s, lives
        line.repeats_s[line.seq] = now_s
        if len(line.repeats_s) > REPEATS_KEPT:
            del line.repeats_s[next(iter(line.repeats_s))]
        request = PlaceRequested(
            district=district,
            life=self.life,
            seq=line.seq,
            epoch=max(epoch, line.epoch),
            rank=state.rank,
            holds=holds,
            groups=groups,
            seen=0 if state.asks and groups else line.seen,
            stands=state.stands,
            docked=state.docked,
            avoid=state.avoid if groups else (),
            chain=state.chain if groups else (),
            removal=state.removal,
        )
        request = self._sign(request)
        self._mark = request.mark
        said = request
        if epoch != NO_EPOCH:
            line.rolled = (max(line.rolled[0], epoch), line.seq)
            if epoch > line.epoch:
                # Nobody but who runs the recovery poll is told an epoch which that one alone has told.
                said = self._sign(msgspec.structs.replace(request, epoch=line.epoch, key=b"", signature=b""))
        line.request, line.asked_all, line.asks = said, False, state.asks and bool(groups)
        for place in [
            one for one, number in line.confirmed.items() if number <= line.seen and one not in holds
        ]:
            del line.confirmed[place]
        self._life.send(to or replicas[(line.epoch + line.turn) % len(replicas)], request)
        if waits and not to and line.agreed == NO_EPOCH:
            self._say_to_all(line, replicas[(line.epoch + line.turn) % len(replicas)])
        if not waits:
            return
        patience_s = min(
            max(2.0 * self.round_s + 0.2, LEAST_AGAIN_S) * 2.0 ** min(line.tries, 3),
            max(MOST_AGAIN_S, MOST_ROUNDS * self.round_s),
        )
        self._life.alarm((REQUEST_AGAIN, district), now_s + patience_s)

    def keeps(self, agent: str, district: str) -> bool:
        """Whether an agent is a replica of a district's reservation table: nobody else's word about it counts."""
        return agent in self._replicas_of.get(district, ())

    def is_answered(self, granted: PlaceGranted) -> bool:
        """Whether an answer was given after what was said last had come."""
        return granted.upto >= self._lines[granted.district].since

    def is_anothers(self, sender: str, granted: PlaceGranted) -> bool:
        """Whether a replica answers a request of this life that was never said: somebody else speaks under its name. Its next request outbids that one."""
        replicas = self._replicas_of.get(granted.district, ())
        line = self._lines.get(granted.district)
        said = line.seq if line is not None else 0
        if sender not in replicas or granted.life != self.life or granted.upto <= said:
            return False
        if not self._is_meant(granted):
            return False
        self._lines.setdefault(granted.district, _Line()).seq = granted.upto
        return True

    def on_granted(self, sender: str, granted: PlaceGranted, now_s: float) -> tuple[str, ...] | None:
        """What an answer grants that was not seen before; None when it is not to be believed."""
        replicas = self._replicas_of.get(granted.district, ())
        if granted.life != self.life or not replicas or replicas[granted.epoch % len(replicas)] != sender:
            return None
        if not self._is_meant(granted):
            return None
        line = self._lines.setdefault(granted.district, _Line())
        if _is_over(line, granted):
            return None
        if not self._is_agreed(line, sender, granted.district, granted.epoch):
            line.missed = (sender, granted)
            self._say_to_all(line, sender)
            return None
        line.note_new_table(granted)
        if not self._is_confirmed(line, granted):
            if line.missed is None and not line.unanswered:
                self._life.alarm((REQUEST_AGAIN, granted.district), now_s + LEAST_AGAIN_S)
            line.missed = (sender, granted)
            return None
        line.epoch, line.turn, line.missed = granted.epoch, 0, None
        fresh = tuple(reservation.place for reservation in granted.grants if reservation.number > line.seen)
        line.seen = max((line.seen, *(reservation.number for reservation in granted.grants)))
        if granted.upto >= line.since:
            is_late = granted.upto < line.seq
            if line.unanswered:
                self._late = self._late + 1 if is_late else 0
            if line.unanswered and (self._late >= LATE_IN_ROW if is_late else not line.tries):
                said_s = line.repeats_s.get(granted.upto, line.said_s)
                self.round_s += (LATE_GAIN if is_late else GAIN) * (now_s - said_s - self.round_s)
                if not line.tries:
                    self._lost_frac -= LOSS_GAIN * self._lost_frac
            line.unanswered, line.tries = False, 0
            line.hindered = granted.blocked is not Blocked.NO
            if line.hindered:
                again_s = LOSSY_AGAIN_S if self._lost_frac > LOSSY_FRAC else WAITS_AGAIN_S
                self._life.alarm((REQUEST_AGAIN, granted.district), now_s + again_s)
            else:
                self._life.cancel((REQUEST_AGAIN, granted.district))
        return fresh

    def on_confirmed(self, sender: str, confirmed: PlaceConfirmed) -> bool:
        """The witness of a reservation table has told what it has copied; False when it is not to be believed."""
        replicas = self._replicas_of.get(confirmed.district, ())
        if not replicas or _witness(replicas, confirmed.epoch) != sender:
            return False
        line = self._lines.setdefault(confirmed.district, _Line())
        if confirmed.epoch < line.confirmed_epoch:
            return False
        if not self._is_agreed(line, sender, confirmed.district, confirmed.epoch):
            line.early = confirmed
            return True
        self._take_confirmed(line, confirmed)
        return True

    def _take_confirmed(self, line: _Line, confirmed: PlaceConfirmed) -> None:
        line.early, line.witness_asked, line.confirmed_epoch = None, 0, confirmed.epoch
        line.confirmed = {one.place: one.number for one in confirmed.grants if one.mark == self._mark}

    def _is_confirmed(self, line: _Line, granted: PlaceGranted) -> bool:
        """Whether the witness has all that is news to the vehicle, or does not answer."""
        replicas = self._replicas_of[granted.district]
        if len(replicas) == 1 or line.witness_asked > WITNESS_ASKED:
            return True
        if line.early is not None and line.early.epoch == granted.epoch:
            self._take_confirmed(line, line.early)
        known = line.confirmed if line.confirmed_epoch == granted.epoch else {}
        asked = {place for group in line.groups for place in group} if line.asks else ()
        return all(
            known.get(reservation.place) == reservation.number
            for reservation in granted.grants
            if reservation.number > line.seen or reservation.place in asked
        )

    def _is_meant(self, granted: PlaceGranted) -> bool:
        """Whether it is no answer to somebody else who speaks under its name, with another key."""
        return not granted.mark or granted.mark == (self._mark or UNSIGNED)

    def count_as_said(
        self, district: str, holds: tuple[str, ...], groups: tuple[tuple[str, ...], ...], state: State
    ) -> None:
        """The vehicle has taken all that it was granted: the replica knows what it holds without being told."""
        line = self._lines[district]
        line.content, line.groups, line.lives = _content(holds, groups, state), groups, bool(holds or groups)

    def on_holds_asked(self, sender: str, asked: HoldsAsked) -> bool:
        """Somebody else keeps the table; True when it is to be told."""
        if not self.keeps(sender, asked.district):
            return False
        line = self._lines.setdefault(asked.district, _Line())
        if asked.recovery_poll:
            # Who calls it is alone with its epoch. It is answered under that one (`say`), for it counts no other; what is told is no grant, and
            # from now on no earlier one counts.
            line.words[sender] = max(line.words.get(sender, 0), asked.epoch)
            line.rolled_after = line.agreed
            # Nor can it be so far that nobody else leads ever after: who leads begins a later one when it is told.
            line.epoch, line.turn = max(line.epoch, min(asked.epoch, line.agreed + OUTBID_MAX)), 0
            return True
        if asked.epoch < line.epoch:
            return False
        if not self._is_agreed(line, sender, asked.district, asked.epoch):
            if line.lives or line.unanswered:
                self._say_to_all(line, "")
                return False
            # A copy misses the word by which something was given back, and nobody else may ask for that.
            replicas = self._replicas_of[asked.district]
            return replicas[asked.epoch % len(replicas)] != sender
        line.epoch, line.turn = asked.epoch, 0
        return not line.asked_all

    def take_missed(self, district: str) -> tuple[str, PlaceGranted] | None:
        """An answer that can be believed now, and by whom it was given: a majority have told its epoch, and the witness has it. None for none."""
        line = self._lines.get(district)
        if line is None or line.missed is None or line.missed[1].epoch != line.agreed:
            return None
        if not self._is_confirmed(line, line.missed[1]):
            return None
        missed, line.missed = line.missed, None
        return missed

    def _is_agreed(self, line: _Line, sender: str, district: str, epoch: int) -> bool:
        """Whether a replica tells an epoch that a majority have told."""
        if epoch > line.agreed:
            line.words[sender] = max(line.words.get(sender, 0), epoch)
            alike = sum(word == epoch for word in line.words.values())
            if alike > len(self._replicas_of[district]) // 2:
                line.agreed = epoch
        return epoch == line.agreed

    def _say_to_all(self, line: _Line, but: str) -> None:
        """Say once more to all replicas what was said last: those who do not keep the table tell under which epoch it is kept."""
        if line.asked_all or line.request is None:
            return
        line.asked_all = True
        for replica in self._replicas_of[line.request.district]:
            if replica != but:
                self._life.send(replica, line.request)


def _witness(replicas: Sequence[str], epoch: int) -> str:
    """Whose word about what a reservation table grants is asked for, beside that of the one who keeps it."""
    return replicas[(epoch + 1) % len(replicas)]


def _is_over(line: _Line, granted: PlaceGranted) -> bool:
    """Whether an answer is of an earlier epoch; or it was on its way when the vehicle told in a recovery poll that it does not hold this."""
    rolled, answer = line.rolled
    is_overtaken = granted.epoch < rolled and granted.upto < answer
    return granted.epoch < line.epoch or (is_overtaken and bool(granted.grants))


def _content(holds: tuple[str, ...], groups: tuple[tuple[str, ...], ...], state: State) -> object:
    """What of a request is news: for whom one waits, and since when, only with something wanted; where to make room only when it stands."""
    if not groups:
        return holds, groups, state.docked and bool(holds)
    if not state.stands:
        return holds, groups, state.rank
    return holds, groups, state
