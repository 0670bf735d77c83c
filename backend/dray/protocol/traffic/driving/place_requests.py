"""A vehicle's requests to the replicas of reservation tables: its whole state in each district, repeated until it is answered.

A vehicle accepts only grants that it can believe (`evidence.py`). While one replica alone reports a later epoch, the vehicle sends its
request to all replicas: those that keep copies answer with their epoch.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence

import msgspec
from msgspec import UNSET

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
from dray.protocol.traffic.driving.evidence import NO_EPOCH, Evidence
from dray.protocol.traffic.numbers import ALONE_MAX, OUTBID_MAX

REQUEST_AGAIN = "request again"

LEAST_AGAIN_S, MOST_AGAIN_S, MOST_ROUNDS = 0.6, 8.0, 1.5
"""Least and most time until a request is repeated: twice the round trip plus 0.2 s, doubled with each repetition. If `MOST_ROUNDS`
round trips take longer than `MOST_AGAIN_S`, they are the limit."""

WAITS_AGAIN_S, LOSSY_AGAIN_S = 3.0, 1.5
"""Time until an answered but ungranted request is repeated, since its grant may have been lost. The shorter one applies when more
than `LOSSY_FRAC` of the first requests get no answer."""

LOSSY_FRAC = 0.05

NEXT_REPLICA_AFTER = 2
"""Unanswered repetitions to one replica before the request goes to the next one."""

REPEATS_KEPT = 8
"""Repetitions of one request whose sending times are kept; no link delays an answer longer."""

FIRST_ROUND_S = 0.3
"""Assumed round trip before the first answer."""

GAIN, LATE_GAIN = 0.2, 0.5
"""Weights of the newest round trip: usually, and when the request was repeated before its answer came, as the estimate is too short
then. An answer to a repetition is no measurement: the request was lost, or its replica could not answer yet."""

LATE_IN_ROW = 3
"""Late answers in a row that show a slow link, and not only a replica that has just started or taken a table over."""

LOSS_GAIN = 0.05
"""Weight of the newest request in the share of unanswered ones."""


Sign = Callable[[PlaceRequested], PlaceRequested]
"""Returns the same request with the vehicle's key and signature."""


def unsigned(request: PlaceRequested) -> PlaceRequested:
    """Return the request unchanged: without a key, any agent with the vehicle's name speaks for its places."""
    return request


class State(msgspec.Struct, frozen=True, gc=False):
    """The common part of all requests at one moment."""

    rank: Rank
    stands: bool
    docked: bool
    avoid: tuple[str, ...]
    chain: tuple[str, ...]
    removal: int = 0
    asks: bool = False
    """Whether it requests the place where it stands, which it does not hold: such a request gives nothing back, and only a grant with a
    number that it has not seen answers it."""


class _Line:
    """The correspondence about one district."""

    __slots__ = (
        "asked_all",
        "asks",
        "content",
        "epoch",
        "evidence",
        "groups",
        "hindered",
        "lives",
        "repeats_s",
        "request",
        "rolled",
        "said_s",
        "seen",
        "seq",
        "settles",
        "since",
        "tries",
        "turn",
        "unanswered",
    )

    def __init__(self, evidence: Evidence) -> None:
        self.evidence = evidence
        self.seq = 0
        self.since = 0
        """The first request with the present content."""
        self.seen = 0
        self.epoch = 0
        """The table's epoch; answers under earlier ones are refused. It may be above the agreed one while a recovery poll runs."""
        self.request: PlaceRequested | None = None
        """The newest request."""
        self.asked_all = False
        """Whether that request went to all replicas."""
        self.asks = False
        """Whether the newest request asks for the place where the vehicle stands."""
        self.settles = False
        """Whether the next request is a release that a copy misses."""
        self.content: object = None
        """The content of the newest request; None before the first one."""
        self.groups: tuple[tuple[str, ...], ...] = ()
        self.unanswered = False
        self.hindered = False
        """Whether the answer did not grant everything."""
        self.tries = 0
        self.turn = 0
        """Offset of the replica that gets the requests from the epoch's leader."""
        self.said_s = 0.0
        self.repeats_s: dict[int, float] = {}
        """Number of the first request with the present content, and of its repetitions -> when it was sent. Answers name a number."""
        self.rolled = (NO_EPOCH, 0)
        """Latest epoch of an answered recovery poll, and the number of the newest answer to one."""
        self.lives = False
        """Whether the replica knows of places that are held or wanted."""

    @property
    def since_poll(self) -> int:
        """The request from which on the table of a recovery poll answers."""
        return max(self.rolled[1], self.since)


class PlaceRequests:
    """The correspondence of one vehicle with the replicas of all districts.

    Args:
        incarnation: number of starts of the vehicle's agent.
        replicas_of: district -> its replicas, in the order of their turns.
        sign: signs its requests.

    Attributes:
        round_s: estimated time to an answer: two messages and the copying.
    """

    def __init__(
        self, incarnation: int, replicas_of: Mapping[str, Sequence[str]], life: Life, sign: Sign = unsigned
    ) -> None:
        self.life = incarnation
        self._sign = sign
        self._mark = b""
        """The mark of its key in the newest request."""
        self._replicas_of = replicas_of
        self._life = life
        self._lines: dict[str, _Line] = {}
        self.round_s = FIRST_ROUND_S
        self._lost_frac = 0.0
        self._late = 0
        """Requests in a row whose answer came after their repetition."""

    @property
    def districts(self) -> Iterable[str]:
        """Districts whose replicas know of places that are held or wanted."""
        return [district for district, line in self._lines.items() if line.lives]

    def open(self, district: str) -> None:
        """Let the next requests include this district, even if nothing is held or wanted there."""
        self._line(district).lives = True

    def groups(self, district: str) -> tuple[tuple[str, ...], ...]:
        """The groups of the newest request."""
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
        asked: bool = False,
        to: str = "",
        epoch: int = NO_EPOCH,
    ) -> None:
        """Send a request, unless its content is unchanged.

        A replica may ask more often than an answer takes. So an unchanged request that it asks for before the answer has come is a
        repetition: answers to the earlier ones count, and its alarm is not put off.

        Args:
            district: the district of the request.
            holds: the places that it holds there.
            groups: the groups that it wants there, in order.
            state: the common part of all requests.
            now_s: the present time.
            anew: send it also when it is unchanged.
            asked: likewise, because a replica has asked.
            to: the replica that has asked; empty for the leader of the table.
            epoch: of the recovery poll that this answers, if any.
        """
        line = self._lines.get(district)
        if line is None:
            if not holds and not groups and not anew and not asked:
                return
            line = self._line(district)
        content = _content(holds, groups, state)
        if line.content == content and not anew:
            if not asked:
                return
            if line.unanswered:
                self._send(district, line, holds, groups, state, now_s, repeats=True)
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
        """Repeat a request whose alarm has come: it was not answered, or not granted in full."""
        line = self._lines[district]
        evidence = line.evidence
        if evidence.waits_for_witness:
            # The answer may be forged, so the leader is asked again, too.
            evidence.witness_asked += 1
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
        if evidence.waits_for_witness and line.request is not None:
            line.asked_all = True
            self._life.send(evidence.witness(evidence.agreed), line.request)

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
        *,
        repeats: bool = False,
    ) -> None:
        replicas = self._replicas_of[district]
        line.seq += 1
        gives_back, line.settles = line.settles, False
        lives = bool(holds or groups)
        # A recovery poll asks again if this is lost, so a vehicle with nothing there waits for no answer.
        waits = lives or line.unanswered or not to
        line.unanswered, line.said_s, line.lives = waits, now_s, lives
        line.repeats_s[line.seq] = now_s
        if len(line.repeats_s) > REPEATS_KEPT:
            del line.repeats_s[next(iter(line.repeats_s))]
        asks = state.asks and bool(groups)
        request = PlaceRequested(
            district=district,
            life=self.life,
            seq=line.seq,
            epoch=max(epoch, line.epoch),
            rank=state.rank,
            # A release must not name the place where the vehicle stands, which it asks for.
            holds=tuple(sorted({*holds, *groups[0]})) if gives_back and asks else holds,
            groups=groups,
            seen=0 if asks and not gives_back else line.seen,
            stands=state.stands,
            docked=state.docked,
            avoid=state.avoid if groups else (),
            chain=state.chain if groups else (),
            removal=state.removal,
            renews=line.seen if asks else 0,
        )
        request = self._sign(request)
        self._mark = request.mark
        said = request
        if epoch != NO_EPOCH:
            line.rolled = (max(line.rolled[0], epoch), line.seq)
            if epoch > line.epoch:
                # Other replicas are not told this epoch, which only the poll's own replica has reported.
                said = self._sign(msgspec.structs.replace(request, epoch=line.epoch, key=b"", signature=b""))
        line.request, line.asked_all, line.asks = said, False, asks
        line.evidence.forget_released(line.seen, holds)
        self._life.send(to or replicas[(line.epoch + line.turn) % len(replicas)], request)
        if waits and not to and line.evidence.agreed == NO_EPOCH:
            self._say_to_all(line, replicas[(line.epoch + line.turn) % len(replicas)])
        if not waits or repeats:
            return
        patience_s = min(
            max(2.0 * self.round_s + 0.2, LEAST_AGAIN_S) * 2.0 ** min(line.tries, 3),
            max(MOST_AGAIN_S, MOST_ROUNDS * self.round_s),
        )
        self._life.alarm((REQUEST_AGAIN, district), now_s + patience_s)

    def keeps(self, agent: str, district: str) -> bool:
        """Whether an agent is a replica of a district's table."""
        return agent in self._replicas_of.get(district, ())

    def is_answered(self, granted: PlaceGranted) -> bool:
        """Whether an answer refers to the present content of the requests."""
        return granted.upto >= self._lines[granted.district].since

    def is_anothers(self, sender: str, granted: PlaceGranted) -> bool:
        """Whether an answer is to a request of this life that was never sent: an impostor's.

        The next request gets a higher number, or an honest table would take it for an overtaken one. A replica that lies cannot bring
        it near the end of numbers, where the vehicle could say nothing more.
        """
        replicas = self._replicas_of.get(granted.district, ())
        line = self._lines.get(granted.district)
        said = line.seq if line is not None else 0
        if sender not in replicas or granted.life != self.life or granted.upto <= said:
            return False
        if not self._is_meant(granted):
            return False
        self._line(granted.district).seq = max(said, min(granted.upto, ALONE_MAX))
        return True

    def on_granted(self, sender: str, granted: PlaceGranted, now_s: float) -> tuple[str, ...] | None:
        """The newly granted places of an answer; None when the answer is not accepted, or not yet."""
        replicas = self._replicas_of.get(granted.district, ())
        if granted.life != self.life or not replicas or replicas[granted.epoch % len(replicas)] != sender:
            return None
        if not self._is_meant(granted):
            return None
        line = self._line(granted.district)
        evidence = line.evidence
        if _is_over(line, granted):
            return None
        if not evidence.is_agreed(sender, granted.epoch):
            evidence.unbelieved = (sender, granted)
            self._say_to_all(line, sender)
            return None
        if not self._is_confirmed(line, granted):
            if evidence.unbelieved is None and not line.unanswered:
                self._life.alarm((REQUEST_AGAIN, granted.district), now_s + LEAST_AGAIN_S)
            evidence.unbelieved = (sender, granted)
            return None
        line.seen = evidence.accept(granted, line.seen, line.since_poll)
        line.epoch, line.turn = granted.epoch, 0
        is_old = line.asks and any(
            reservation.number <= line.seen and reservation.place in group
            for reservation in granted.grants
            for group in line.groups
        )
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
            line.hindered = granted.blocked is not Blocked.NO or is_old
            if line.hindered:
                again_s = LOSSY_AGAIN_S if self._lost_frac > LOSSY_FRAC else WAITS_AGAIN_S
                self._life.alarm((REQUEST_AGAIN, granted.district), now_s + again_s)
            else:
                self._life.cancel((REQUEST_AGAIN, granted.district))
        return fresh

    def on_confirmed(self, sender: str, confirmed: PlaceConfirmed) -> bool:
        """Note the witness's confirmation of the lines that it has copied; False when it is refused."""
        if confirmed.district not in self._replicas_of:
            return False
        return self._line(confirmed.district).evidence.on_confirmed(sender, confirmed, self._mark)

    def _is_confirmed(self, line: _Line, granted: PlaceGranted) -> bool:
        return line.evidence.is_confirmed(granted, self._mark, line.seen, line.since_poll)

    def _is_meant(self, granted: PlaceGranted) -> bool:
        """Whether an answer is for this vehicle's key, and not for another key under its name."""
        return not granted.mark or granted.mark == (self._mark or UNSIGNED)

    def count_as_said(
        self, district: str, holds: tuple[str, ...], groups: tuple[tuple[str, ...], ...], state: State
    ) -> None:
        """Count this content as sent: the vehicle has taken all its grants, so the replica knows what it holds."""
        line = self._lines[district]
        line.content, line.groups, line.lives = _content(holds, groups, state), groups, bool(holds or groups)

    def on_holds_asked(self, sender: str, asked: HoldsAsked, *, settles: bool = True) -> bool:
        """A replica asks what the vehicle holds; True when it must be answered.

        Args:
            sender: the replica.
            asked: its question.
            settles: whether the vehicle knows all that it holds: only then it says a release that a copy misses.
        """
        if not self.keeps(sender, asked.district):
            return False
        line = self._line(asked.district)
        evidence = line.evidence
        if asked.recovery_poll:
            # Only the poll's replica reports this epoch. It accepts no other, so the answer carries it (`say`). An answer is no
            # grant. From now on, grants under earlier epochs are refused.
            evidence.on_poll(sender, asked.epoch)
            # The raise is limited, so that others can lead again: a leader that hears of a later epoch begins a still later one.
            line.epoch, line.turn = max(line.epoch, min(asked.epoch, evidence.agreed + OUTBID_MAX)), 0
            return True
        if asked.epoch < line.epoch:
            return False
        if asked.misses is not UNSET and settles:
            evidence.on_release_missed(sender, asked.epoch, asked.misses)
        if not evidence.is_agreed(sender, asked.epoch):
            if line.lives or line.unanswered:
                self._say_to_all(line, "")
                return False
            # Only a replica whose copy misses a release may ask under such an epoch, and not the epoch's leader.
            return evidence.leader(asked.epoch) != sender
        line.epoch, line.turn = asked.epoch, 0
        if settles and asked.misses is not UNSET:
            # All grants up to that number count as seen: one that is still under way is void.
            settled = evidence.number_to_settle()
            line.settles, line.seen = settled > 0, max(line.seen, settled)
            return line.settles or not line.asked_all
        return not line.asked_all

    def take_believed(self, district: str) -> tuple[str, PlaceGranted] | None:
        """The answer, with its sender, that was not believed at first, and is agreed and confirmed by now; None for none."""
        line = self._lines.get(district)
        if line is None or not line.evidence.waits_for_witness:
            return None
        answer = line.evidence.unbelieved
        if answer is None or not self._is_confirmed(line, answer[1]):
            return None
        line.evidence.unbelieved = None
        return answer

    def _line(self, district: str) -> _Line:
        line = self._lines.get(district)
        if line is None:
            line = self._lines[district] = _Line(Evidence(self._replicas_of[district], self.life))
        return line

    def _say_to_all(self, line: _Line, but: str) -> None:
        """Send the newest request to all other replicas, once: those that keep copies answer with the table's epoch."""
        if line.asked_all or line.request is None:
            return
        line.asked_all = True
        for replica in self._replicas_of[line.request.district]:
            if replica != but:
                self._life.send(replica, line.request)


def _is_over(line: _Line, granted: PlaceGranted) -> bool:
    """Whether an answer is of an earlier epoch, or was sent before the vehicle's answer to a recovery poll."""
    rolled, answer = line.rolled
    is_overtaken = granted.epoch < rolled and granted.upto < answer
    return granted.epoch < line.epoch or (is_overtaken and bool(granted.grants))


def _content(holds: tuple[str, ...], groups: tuple[tuple[str, ...], ...], state: State) -> object:
    """The part of a request whose change is news: the rank only while it wants places, and where to make room only while it stands."""
    if not groups:
        return holds, groups, state.docked and bool(holds)
    if not state.stands:
        return holds, groups, state.rank
    return holds, groups, state
