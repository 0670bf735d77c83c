"""Gaps: the missing numbers of agents' histories, and the times to ask for them again. Pure.

An agent numbers the events of each of its lives from 1 on. So an arriving number reveals missing earlier ones, but no later
ones: the last event of a life may be lost. Heartbeats carry no numbers, and should not for the sake of one listener. So every
agent is regularly asked for events after its last known number, even if nothing seems to be missing. One answer contains the
missing events, and the numbers of stored ones (`EventsKept`), those of earlier lives included. So an answer also reveals lives that were
missed altogether, the newest `LIVES_TOLD`.

    a number was skipped       -> ask for it, after `SETTLE_S`
    a life has begun           -> ask for it, and for the end of the previous one
    nothing is known to miss   -> ask for what comes next, every `TAIL_S`
    no answer, or no progress  -> ask again, after twice the pause

What an agent keeps and the historian cannot vouch for is fetched once more: a doubled event costs a message, a missed one is lost.

An agent gets one question at a time, about its oldest life first. A number is *missing* until it has come, and *gone* when
its agent reports that it is deleted.
"""

from __future__ import annotations

from collections.abc import Iterable

import msgspec

from dray.messages import EventsAsked, EventsKept
from dray.messages.base import COUNT_MAX
from dray.messages.history import EVENTS_PER_ANSWER, HISTORY_KEPT, LIVES_TOLD, LifeKept
from dray.messages.overtaken import OVERTAKES_S

LIVES = LIVES_TOLD + 1
"""Maximum lives of one agent that are followed, the last ones: all that an answer tells of, and the present one."""

MISSING_MAX = 4 * HISTORY_KEPT
"""Maximum missing numbers of one agent that are followed, some 3 MB: more than it keeps."""

SETTLE_S = 1.0
"""Seconds before a skipped number is asked for: most are only late."""

AGAIN_S = (2.0, 60.0)
"""Seconds before the first and between later repetitions of a question, doubling."""

SILENCE_S = 10.0
"""Seconds of silence after which an agent counts as returned, and is asked at once. Twice a resting agent's heartbeat
interval."""

TAIL_S = 60.0
"""Seconds between two questions to an agent without known gaps: two messages a minute, beside a dozen heartbeats
or more."""

ASKED_AT_ONCE = 32
"""Maximum agents with an open question: their answers, of some 200 events each, fit the historian's queue."""


class Known(msgspec.Struct, frozen=True, gc=False):
    """The earlier knowledge of one life of an agent."""

    agent: str
    incarnation: int
    last: int
    missing: tuple[int, ...] = ()
    is_first_asked: bool = False
    """Whether no earlier life is asked for: they were deleted, or are older than those followed."""


class _Life(msgspec.Struct, gc=False):
    """One life of an agent.

    Invariant: every number up to `last` has arrived, is missing, or is gone.
    """

    last: int = 0
    missing: set[int] = msgspec.field(default_factory=set)
    open: bool = True
    """Whether its end is unknown: not reported since its beginning, or since the next life's beginning."""
    skipped_from: int = COUNT_MAX
    """The first number that was skipped without being looked for, since a far later one was heard."""


class _Teller(msgspec.Struct, gc=False):
    """One agent, and the state of its questions.

    Invariant: lives are in order, and the newest is present; an earlier one stays as long as it is open or lacks
    something.
    """

    heard_s: float
    due_s: float
    newest_s: float
    """When it was last heard in its newest life."""
    lives: dict[int, _Life] = msgspec.field(default_factory=dict)
    pause_s: float = AGAIN_S[0]
    waiting: bool = False
    """A question was asked, and its answer may still come."""
    filled: int = 0
    """Missing numbers that have come since the last question."""
    first_asked: int = 0
    """The first life that is asked for; earlier ones only if they are in `lives`."""


class Gaps:
    """Watches the numbers of all agents. Times are of any monotonic clock.

    Args:
        known: the known lives, each agent's in order.
        now_s: the time.
        agents: agents to ask without knowing anything of them. Those without a heartbeat may have reported
            everything while nobody listened.

    Attributes:
        missing: count of numbers that have not come yet, over all agents.
        gone: count of numbers that never will, so far.
    """

    def __init__(self, known: Iterable[Known] = (), now_s: float = 0.0, agents: Iterable[str] = ()) -> None:
        self.missing = 0
        self.gone = 0
        self._tellers: dict[str, _Teller] = {}
        for one in known:
            teller = self._tellers.setdefault(one.agent, _Teller(heard_s=now_s, due_s=now_s, newest_s=now_s))
            if one.is_first_asked:
                teller.first_asked = one.incarnation
            self._begin_life(teller, one.incarnation)
            life = teller.lives[one.incarnation]
            life.last = one.last
            life.missing.update(one.missing[-HISTORY_KEPT:])
            if one.last > HISTORY_KEPT:
                life.skipped_from = 1
            self.missing += len(life.missing)
            self._bound(teller)
        for agent in agents:
            if agent not in self._tellers:
                # Its answer tells its present life.
                self._tellers[agent] = teller = _Teller(heard_s=now_s, due_s=now_s, newest_s=now_s)
                self._begin_life(teller, 1)

    # --- what is heard ---------------------------------------------------------------------------

    def note(self, agent: str, incarnation: int, number: int, now_s: float) -> bool:
        """An event has arrived; doubled and late ones are normal.

        Returns:
            Whether it was missing, or may have been: other listeners may have missed it, too.
        """
        teller = self._heard(agent, incarnation, now_s)
        life = teller.lives.get(incarnation)
        if life is None:
            return False
        if number in life.missing:
            life.missing.remove(number)
            self.missing -= 1
            teller.filled += 1
            return True
        if number <= life.last:
            return False
        if number > life.last + 1:
            self._miss(teller, life, life.last + 1, number)
            self._ask_by(teller, now_s + SETTLE_S)
        life.last = number
        # An answer to the question for later events looks like any other event.
        return teller.waiting

    def note_alive(self, agent: str, incarnation: int, now_s: float) -> None:
        """The agent was heard, in this life."""
        self._heard(agent, incarnation, now_s, present=True)

    def answered(self, agent: str, kept: EventsKept, now_s: float) -> int:
        """The agent has reported its stored numbers, after the events asked for.

        Returns:
            The count of missing numbers that are gone.
        """
        teller = self._heard(agent, kept.life, now_s, present=True)
        gone, found = 0, teller.filled > 0
        if (life := teller.lives.get(kept.incarnation)) is not None:
            over = kept.incarnation < kept.life
            found |= kept.last > life.last or life.open
            gone = self._end_at(teller, life, kept.first, kept.last)
            # Of an ended life without stored events, not even the last number is known.
            nothing_left = over and kept.last < kept.first
            gone += self._give_up(life, life.last + 1 if nothing_left else kept.first)
            life.open = not over and kept.incarnation != next(reversed(teller.lives))
        if kept.earlier is not None and _is_credible(kept.earlier):
            gone += self._compare(teller, kept.life, kept.earlier)
        _forget_whole_lives(teller)
        teller.first_asked = max(teller.first_asked, min(kept.life, next(iter(teller.lives))))
        self._trim(teller)
        teller.waiting = False
        lacking = any(life.missing or life.open for life in teller.lives.values())
        if lacking and not (found or gone):
            teller.due_s = now_s + teller.pause_s
        else:
            teller.pause_s = AGAIN_S[0]
            teller.due_s = now_s if lacking else now_s + TAIL_S
        return gone

    # --- what is asked ---------------------------------------------------------------------------

    def due(self, now_s: float) -> list[tuple[str, EventsAsked]]:
        """The questions to ask now; call it about once a second."""
        room = ASKED_AT_ONCE - sum(teller.waiting for teller in self._tellers.values())
        due = [item for item in self._tellers.items() if item[1].due_s <= now_s]
        room += sum(teller.waiting for _, teller in due)
        # The longest waiting come first, so that silent agents do not block the others.
        due.sort(key=lambda item: item[1].due_s)
        for _, teller in due[:room]:
            teller.waiting, teller.filled = True, 0
            teller.due_s = now_s + teller.pause_s
            teller.pause_s = min(2 * teller.pause_s, AGAIN_S[1])
        return [(agent, _question(teller)) for agent, teller in due[:room]]

    # --- how it is done --------------------------------------------------------------------------

    def _heard(self, agent: str, incarnation: int, now_s: float, *, present: bool = False) -> _Teller:
        """The agent was heard, about this life or, if `present`, in it."""
        teller = self._tellers.get(agent)
        if teller is None:
            teller = self._tellers[agent] = _Teller(heard_s=now_s, due_s=now_s + SETTLE_S, newest_s=now_s)
        elif now_s > teller.heard_s + SILENCE_S:
            teller.pause_s, teller.waiting = AGAIN_S[0], False
            self._ask_by(teller, now_s + SETTLE_S)
        teller.heard_s = now_s
        newest = next(reversed(teller.lives), 0)
        spoken = present or incarnation not in teller.lives
        if spoken and incarnation < newest and now_s - teller.newest_s > OVERTAKES_S:
            # Nobody speaks in that life any more: a thief of its certificate has named it.
            for later in [life for life in teller.lives if life > incarnation]:
                self._give_up(life := teller.lives.pop(later), life.last + 1)
            teller.first_asked = min(teller.first_asked, incarnation)
            newest = next(reversed(teller.lives), 0)
        if incarnation > newest:
            self._begin_life(teller, incarnation)
            self._ask_by(teller, now_s + SETTLE_S)
        if incarnation >= newest:
            teller.newest_s = now_s
        return teller

    def _begin_life(self, teller: _Teller, incarnation: int) -> None:
        """A newer life has begun; lives in between may have been missed."""
        newest = next(reversed(teller.lives), 0)
        if newest:
            teller.lives[newest].open = True
        for life in range(max(newest, incarnation - LIVES, teller.first_asked - 1) + 1, incarnation + 1):
            teller.lives[life] = _Life()
        self._trim(teller)

    def _trim(self, teller: _Teller) -> None:
        while len(teller.lives) > LIVES:
            oldest = teller.lives.pop(next(iter(teller.lives)))
            self._give_up(oldest, oldest.last + 1)

    def _compare(self, teller: _Teller, present: int, earlier: tuple[LifeKept, ...]) -> int:
        """Compare what is known of ended lives with what the agent keeps of them.

        Returns:
            The count of missing numbers that are gone.
        """
        gone = 0
        for kept in earlier:
            if not teller.first_asked <= kept.incarnation < present:
                continue
            if (life := teller.lives.get(kept.incarnation)) is None:
                life = teller.lives[kept.incarnation] = _Life()
            life.open = False
            gone += self._end_at(teller, life, kept.first, kept.last)
            gone += self._give_up(life, kept.first)
        # Of lives that it does not name, it keeps nothing.
        told = {kept.incarnation for kept in earlier}
        since = earlier[0].incarnation if len(earlier) == LIVES_TOLD else 0
        for incarnation, life in teller.lives.items():
            if since <= incarnation < present and incarnation not in told:
                life.open = False
                gone += self._give_up(life, life.last + 1)
        teller.lives = dict(sorted(teller.lives.items()))
        return gone

    def _end_at(self, teller: _Teller, life: _Life, first: int, last: int) -> int:
        """The agent has told its events up to the last one, so far, and keeps them from the first one on.

        Returns:
            The count of later numbers than were known that are gone.
        """
        if first <= last < life.last:
            # It has told no later ones: they are a thief's, or on their way, and then they are fetched once more.
            self.missing -= len(life.missing)
            life.missing = {number for number in life.missing if number <= last}
            if last < life.last - HISTORY_KEPT:
                # For a thief's number, others were not looked for that it keeps.
                life.missing.update(range(max(life.skipped_from, first, last + 1 - HISTORY_KEPT), last + 1))
                life.skipped_from = COUNT_MAX
            self.missing += len(life.missing)
            life.last = last
        if last <= life.last:
            return 0
        kept = max(life.last + 1, min(first, last + 1))
        gone = kept - life.last - 1
        self.gone += gone
        self._miss(teller, life, kept, last + 1)
        life.last = last
        return gone

    def _ask_by(self, teller: _Teller, when_s: float) -> None:
        if not teller.waiting:
            teller.due_s = min(teller.due_s, when_s)

    def _miss(self, teller: _Teller, life: _Life, first: int, end: int) -> None:
        """Note skipped numbers; `end` is excluded."""
        sought = max(first, end - HISTORY_KEPT)
        self.gone += sought - first
        if sought > first:
            life.skipped_from = min(life.skipped_from, first)
        life.missing.update(range(sought, end))
        self.missing += end - sought
        if len(life.missing) > HISTORY_KEPT:
            missing = sorted(life.missing)
            life.skipped_from = min(life.skipped_from, missing[0])
            self._give_up(life, missing[-HISTORY_KEPT])
        self._bound(teller)

    def _bound(self, teller: _Teller) -> None:
        surplus = sum(len(life.missing) for life in teller.lives.values()) - MISSING_MAX
        for life in teller.lives.values():
            if surplus <= 0:
                break
            if life.missing:
                # It is asked for from its beginning when there is room.
                surplus -= self._give_up(life, life.last + 1)
                life.last, life.open = 0, True

    def _give_up(self, life: _Life, first: int) -> int:
        """Numbers before this one are gone; returns the count of missing ones among them."""
        gone = {number for number in life.missing if number < first}
        life.missing -= gone
        self.missing -= len(gone)
        self.gone += len(gone)
        return len(gone)


def _is_credible(earlier: tuple[LifeKept, ...]) -> bool:
    """Whether an agent can keep as much."""
    lengths = [kept.last - kept.first + 1 for kept in earlier]
    return all(length > 0 for length in lengths) and sum(lengths) <= HISTORY_KEPT


def _forget_whole_lives(teller: _Teller) -> None:
    newest = next(reversed(teller.lives))
    for incarnation, life in list(teller.lives.items()):
        if incarnation != newest and not life.missing and not life.open:
            del teller.lives[incarnation]


def _question(teller: _Teller) -> EventsAsked:
    lacking = (item for item in teller.lives.items() if item[1].missing or item[1].open)
    incarnation, life = next(lacking, None) or next(reversed(teller.lives.items()))
    if not life.missing:
        return EventsAsked(incarnation=incarnation, first=life.last + 1, last=life.last + EVENTS_PER_ANSWER)
    first = min(life.missing)
    last = max(number for number in life.missing if number < first + EVENTS_PER_ANSWER)
    return EventsAsked(incarnation=incarnation, first=first, last=last)
