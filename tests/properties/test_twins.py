"""Ranking and suspicion, compared with naive twins.

A twin is the same thing written a second time in the plainest way: it keeps everything that it was ever told,
and works every answer out anew from all of it.
"""

from __future__ import annotations

import math

from credulous import Credulous
from effects import facts
from hypothesis import given
from hypothesis import strategies as st
from msgspec import UNSET
from spoken import accepted, bid, declined, rhb, transport

from dray.messages import AtvHeartbeat, AtvStatus, Bid, HelpWanted, Reason, Role
from dray.messages.fact import AwardGiven
from dray.messages.people.command import PROMISE_MAX_S
from dray.protocol.contract_net.auction import Auction
from dray.protocol.contract_net.auction_rules import AuctionRules
from dray.protocol.contract_net.terms import Place, Terms
from dray.protocol.liveness.failure_detector import FailureDetector
from dray.protocol.liveness.suspicion import (
    DEVIATIONS,
    FALSE_ALARM,
    GAIN,
    IDLE_INTERVAL_S,
    JITTER_S,
    LATENESS_MAX_S,
    MISSES,
    MISSES_MAX,
    WORKING_INTERVAL_S,
    ArrivalStatistics,
    allowed_misses,
)
from dray.protocol.runtime.life import Life

CLOSE = 1e-9
"""Two ways to add up the same numbers differ by rounding only."""

# --- ranking -------------------------------------------------------------------------------------

BIDDERS = [f"ATV{number}" for number in range(8)]

OFFERS = st.lists(
    st.tuples(st.sampled_from(BIDDERS), st.sampled_from([40.0, 50.0, 60.0]), st.sampled_from([100.0, 110.0])),
    min_size=1,
    max_size=20,
)


def next_to_ask(offers: list[tuple[str, Bid]], asked: list[str]) -> str:
    """The twin: of everybody's first bid in the round, the best one of those who were not asked yet."""
    last = {bidder: offer for bidder, offer in reversed(offers) if bidder not in asked}
    order = sorted(last, key=lambda each: (last[each].cost.total_s, last[each].finish_s, each))
    return order[0] if order else ""


@given(offers=OFFERS, refusals=st.integers(0, 8))
def test_the_ranking_is_the_naive_one_and_so_are_those_who_are_left(
    offers: list[tuple[str, float, float]], refusals: int
) -> None:
    life = Life()
    terms = Terms(task="T1", epoch=1, role=Role.PRIMARY, work=transport(), deadline_s=300.0)
    place = Place(x_m=0.0, y_m=0.0, reach_m=10.0)
    auction = Auction("M8", terms, place, lambda _radius_m: ("k",), AuctionRules(), life, Credulous())
    auction.open(0.0)
    told = [(bidder, bid(cost_s, finish_s=finish_s)) for bidder, cost_s, finish_s in offers]
    for bidder, offer in told:
        auction.on_bid(bidder, offer, 0.5)
    auction.wake(auction.wake_at_s)
    asked: list[str] = []
    while expected := next_to_ask(told, asked):
        asked.append(expected)
        assert [fact.bidder for fact in facts(life.effects, AwardGiven)] == asked
        if len(asked) > refusals:
            auction.on_accepted(expected, accepted(number=len(asked)))
            break
        auction.on_declined(expected, declined(number=len(asked)), 1.0)
    left: list[str] = []
    if auction.winner:
        while expected := next_to_ask(told, asked + left):
            left.append(expected)
    assert [bidder for bidder, _ in auction.left_over] == left


# --- suspicion -----------------------------------------------------------------------------------


class NaiveEar:
    """The twin of `ArrivalStatistics`: a list of everything, weighed anew for every answer."""

    def __init__(self) -> None:
        self.notes: list[tuple[int, float]] = []
        """Of every heartbeat that came: how many before it did not, and its delay (s)."""

    @property
    def loss_frac(self) -> float:
        losses: list[float] = []
        for missed, _ in self.notes:
            losses += [1.0] * min(missed, MISSES_MAX) + [0.0]
        return _weighed(losses, 0.0)

    @property
    def deviation_s(self) -> float:
        delays_s = [delay_s for _, delay_s in self.notes]
        means_s = [
            _weighed(delays_s[1:count], delays_s[0]) if count else delays_s[0]
            for count in range(len(delays_s))
        ]
        off_s = [abs(delay_s - mean_s) for delay_s, mean_s in zip(delays_s, means_s, strict=True)]
        return _weighed(off_s, 0.0)

    def bound_s(self, interval_s: float) -> float:
        lateness_s = min(max(DEVIATIONS * self.deviation_s, JITTER_S), LATENESS_MAX_S)
        return naive_misses(self.loss_frac) * interval_s + lateness_s


def _weighed(values: list[float], first: float) -> float:
    """A running mean that forgets, as one sum."""
    count = len(values)
    recent = sum(GAIN * (1.0 - GAIN) ** (count - 1 - place) * value for place, value in enumerate(values))
    return recent + (1.0 - GAIN) ** count * first


def naive_misses(loss_frac: float) -> int:
    """So many in a row that chance makes them once in 1 / FALSE_ALARM, by trying one after another."""
    for misses in range(MISSES, MISSES_MAX):
        if loss_frac**misses <= FALSE_ALARM * (1.0 + CLOSE):
            return misses
    return MISSES_MAX


@given(st.floats(0.0, 1.0))
def test_the_allowed_misses_are_the_fewest_that_chance_hardly_makes(loss_frac: float) -> None:
    misses = allowed_misses(loss_frac)
    if any(math.isclose(loss_frac**each, FALSE_ALARM, rel_tol=1e-6) for each in (misses - 1, misses)):
        return  # On the very edge rounding decides.
    assert misses == naive_misses(loss_frac)


BEATS = st.lists(
    st.tuples(
        st.integers(1, 2),  # The life of the vehicle,
        st.integers(-2, 6),  # how many heartbeats further than the one before,
        st.floats(0.0, 4.0),  # how long after it that comes (s),
        st.floats(0.0, 6.0),  # how long it was under way (s),
        st.sampled_from(["working", "idle", "error", "waits for help"]),
    ),
    max_size=25,
)

Beat = tuple[int, int, float, float, str]


def _heartbeat(life: int, seq: int, said_s: float, status: str) -> AtvHeartbeat:
    beat = rhb("ATV2", seq, said_s, task="" if status == "idle" else "T1")
    changes: dict[str, object] = {"incarnation": life}
    if status in ("error", "waits for help"):
        changes["status"] = AtvStatus.ERROR
    if status == "waits for help":
        changes["help"] = HelpWanted(until_s=said_s + 8.0)
    return _replaced(beat, changes)


def _replaced(beat: AtvHeartbeat, changes: dict[str, object]) -> AtvHeartbeat:
    fields = {name: getattr(beat, name) for name in beat.__struct_fields__}
    return AtvHeartbeat(**(fields | changes))


class NaiveFailureDetector:
    """The twin of `FailureDetector`: every heartbeat that ever came, and what follows from all of them."""

    def __init__(self, ear: NaiveEar, now_s: float) -> None:
        delays_s = [delay_s for _, delay_s in ear.notes]
        wait_s = _weighed(delays_s[1:], delays_s[0]) if delays_s else LATENESS_MAX_S
        self.began_s = now_s + wait_s
        self.prior = list(ear.notes)
        self.heard: list[tuple[float, AtvHeartbeat]] = []

    def news(self) -> list[tuple[float, AtvHeartbeat]]:
        """Those that were not overtaken by a newer one."""
        news: list[tuple[float, AtvHeartbeat]] = []
        for at_s, beat in self.heard:
            if all((each.incarnation, each.seq) < (beat.incarnation, beat.seq) for _, each in news):
                news.append((at_s, beat))
        return news

    def notes(self) -> list[tuple[int, float]]:
        """What an ear has noted of them."""
        notes: list[tuple[int, float]] = []
        last = (0, 0)
        for at_s, beat in self.news():
            missed = beat.seq - last[1] - 1 if beat.incarnation == last[0] else 0
            # A delay that no link has is a wrong clock's.
            notes.append((missed, min(max(at_s - beat.at_s, 0.0), LATENESS_MAX_S)))
            last = (beat.incarnation, beat.seq)
        return notes

    def failure(self, now_s: float) -> Reason | None:
        ear = NaiveEar()
        ear.notes = self.prior + self.notes()
        news = self.news()
        if not news:
            return Reason.SILENT if now_s >= self.began_s + ear.bound_s(WORKING_INTERVAL_S) else None
        heard_s, beat = news[-1]
        in_need = beat.problem and beat.out_of_service is UNSET
        interval_s = WORKING_INTERVAL_S if beat.task is not None or in_need else IDLE_INTERVAL_S
        if now_s >= heard_s + ear.bound_s(interval_s):
            return Reason.SILENT
        if beat.help is not None:
            left_s = min(beat.help.until_s - beat.at_s, PROMISE_MAX_S)
            return Reason.IN_ERROR if now_s >= heard_s + left_s else None
        return Reason.IN_ERROR if beat.status is AtvStatus.ERROR else None


@given(before=BEATS, beats=BEATS, looks=st.lists(st.floats(0.0, 30.0), max_size=5))
def test_a_detector_suspects_exactly_when_its_naive_twin_does(
    before: list[Beat], beats: list[Beat], looks: list[float]
) -> None:
    prior, ear, now_s = ArrivalStatistics(), NaiveEar(), 100.0
    first, naive_first = (
        FailureDetector("ATV2", WORKING_INTERVAL_S, now_s, prior),
        NaiveFailureDetector(ear, now_s),
    )
    now_s = _play(first, naive_first, before, now_s)
    ear.notes = naive_first.notes()
    detector, twin = (
        FailureDetector("ATV2", WORKING_INTERVAL_S, now_s, prior),
        NaiveFailureDetector(ear, now_s),
    )
    now_s = _play(detector, twin, beats, now_s)
    for look_s in [*looks, detector.fails_at_s - now_s - 1e-6, detector.fails_at_s - now_s + 1e-6]:
        at_s = now_s + max(0.0, look_s)
        assert detector.failure(at_s) == twin.failure(at_s)


def _play(detector: FailureDetector, twin: NaiveFailureDetector, beats: list[Beat], now_s: float) -> float:
    """Let both hear the same; returns when that is over."""
    seq = 10
    for life, step, pause_s, delay_s, status in beats:
        now_s += pause_s
        seq = max(1, seq + step)
        beat = _heartbeat(life, seq, now_s - delay_s, status)
        twin.heard.append((now_s, beat))
        assert detector.on_heartbeat(beat, now_s) is (twin.news()[-1][1] is beat)
    return now_s
