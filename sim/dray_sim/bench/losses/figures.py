"""The figures of a campaign: violations that were found, and the cost of each loss."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from statistics import median, quantiles

from dray.cli.fleet.process_supervisor import REST_S
from dray.errors import UnavailableError
from dray_sim.bench.losses.calling import rows_of
from dray_sim.bench.losses.campaign import Outcome
from dray_sim.bench.losses.cost import Kill, fates
from dray_sim.bench.losses.judgement import Finding, judge
from dray_sim.bench.losses.outage import Outage
from dray_sim.bench.losses.victims import LASTING, Kind
from dray_sim.bench.losses.works import Works
from dray_sim.bench.postgres import MISSING
from dray_sim.bench.row import Row

QUIET = "nobody is killed"

REST = "the rest before a start"

P95 = 18
"""Index of the 95th percentile among the cuts of twenty equal parts."""

HOUR_S = 3600.0


def rows(outcome: Outcome) -> list[Row]:
    """The figures of a campaign.

    Raises:
        UnavailableError: too little was carried to tell anything.
    """
    works = Works(outcome.after.history.events)
    quiet_s, killing_s = works.durations_s(*outcome.quiet_s), works.durations_s(*outcome.killing_s)
    if min(len(quiet_s), len(killing_s)) < 2:
        reason = f"{len(quiet_s)} transports while {QUIET}, {len(killing_s)} after that"
        raise UnavailableError("the benchmark", reason, "let it run for longer")
    return [
        *map(_finding, judge(outcome.after)),
        _flow(outcome, len(killing_s), len(quiet_s)),
        Row("losses: half of all transports", median(killing_s), "s", median(quiet_s), QUIET),
        Row("losses: 95 of 100 transports", _p95(killing_s), "s", _p95(quiet_s), QUIET),
        _punctuality(outcome),
        *(row for kind in Kind for row in _kind(kind, outcome, works, median(quiet_s))),
        *outages_of(outcome.outages, outcome.campaign.dark_s),
    ]


def rows_with_calls(outcome: Outcome) -> list[Row]:
    """Violations that were found, and the results of the calls."""
    found = [*map(_finding, judge(outcome.after))]
    if outcome.called is None:
        return found
    killed = Counter(kill.victim.kind.value for kill in outcome.kills)
    killed["database"] += len(outcome.outages)
    kills = ", ".join(f"{count} x {kind}" for kind, count in killed.items() if count)
    events = outcome.after.history.events
    return [*found, *rows_of(outcome.called, events, outcome.asked_s, f"killed: {kills}")]


def _finding(finding: Finding) -> Row:
    note = "; ".join(finding.seen) or f"of {finding.of:,}"
    return Row(
        f"losses: {finding.what}", len(finding.seen), "", finding.of, finding.of_what, 0.0, note, less=True
    )


def _flow(outcome: Outcome, killing: int, quiet: int) -> Row:
    """Rate of delivered transports during the kills, beside that of the quiet span."""
    figure, baseline = (
        count * HOUR_S / (until_s - since_s)
        for count, (since_s, until_s) in ((killing, outcome.killing_s), (quiet, outcome.quiet_s))
    )
    since_s, until_s = outcome.killing_s
    kills = len(outcome.kills) + len(outcome.outages)
    note = f"a kill every {(until_s - since_s) / kills:.0f} s of the plant"
    return Row("losses: transports in an hour of the plant", figure, "1/h", baseline, QUIET, note=note)


def _punctuality(outcome: Outcome) -> Row:
    orders = outcome.after.orders
    in_time = sum(
        order.delivered_at_s is not None
        and order.due_at_s is not None
        and order.delivered_at_s <= order.due_at_s
        for order in orders
    )
    note = f"the slowest was answered after {outcome.answered_s:.1f} s"
    return Row("losses: orders delivered in time", in_time, "", len(orders), "orders placed", note=note)


def _kind(kind: Kind, outcome: Outcome, works: Works, quiet_s: float) -> Iterable[Row]:
    """The cost of losing one process of this kind."""
    of_kind = [kill for kill in outcome.kills if kill.victim.kind is kind]
    away_s = [kill.away_s for kill in of_kind if kill.away_s is not None]
    if not away_s:
        return
    note = f"{len(of_kind)} killed; at most {max(away_s):.1f} s; {_told(of_kind, works)}".removesuffix("; ")
    rest_s = outcome.campaign.lasting_s if kind in LASTING else REST_S
    yield Row(f"losses: {kind}, away", median(away_s), "s", rest_s, REST, note=note)
    took_s = [
        span.took_s
        for kill in of_kind
        for task in kill.victim.work
        if (span := works.transports.get(task)) is not None and span.took_s is not None
    ]
    if took_s:
        note = f"at most {max(took_s):.0f} s"
        yield Row(f"losses: transport of a {kind}", median(took_s), "s", quiet_s, QUIET, note=note)


def outages_of(outages: Sequence[Outage], dark_s: float) -> Iterable[Row]:
    """The cost of losing the database."""
    away = "losses: database, away"
    if not outages:
        yield Row(away, 0.0, "s", dark_s, REST, note=f"NOT KILLED: {MISSING}")
        return
    away_s, refused_s, behind_s = zip(
        *((outage.away_s, outage.refused_s, outage.behind_s) for outage in outages), strict=True
    )
    before: Counter[str] = sum((outage.before for outage in outages), Counter())
    answers = ", ".join(f"{count} x {what}" for what, count in before.most_common())
    note = f"{len(outages)} killed; at most {max(away_s):.1f} s"
    yield Row(away, median(away_s), "s", dark_s, REST, note=note)
    note = f"at most {max(refused_s):.1f} s; before that {answers}"
    yield Row(
        "losses: database, order sent meanwhile",
        median(refused_s),
        "s",
        median(away_s),
        "the database away",
        note=note,
    )
    note = f"at most {max(behind_s):.1f} s"
    yield Row(
        "losses: database, historian behind",
        median(behind_s),
        "s",
        median(away_s),
        "the database away",
        note=note,
    )


def _told(kills: Sequence[Kill], works: Works) -> str:
    """How the victims' work went on, and after how many seconds of the plant."""
    after_s: dict[str, list[float]] = {}
    for kill in kills:
        for fate in fates(kill, works):
            after_s.setdefault(fate.what, []).append(fate.at_s - kill.at_s)
    return ", ".join(
        f"{len(each)} x {what} after {median(each):.1f} s (at most {max(each):.1f})"
        for what, each in sorted(after_s.items())
    )


def _p95(values: Sequence[float]) -> float:
    return quantiles(values, n=20)[P95]
