"""Benchmark `losses`: what is lost, and what it costs, when processes of a factory are killed under load.

A whole fleet runs on this computer, orders come in over REST, and one process after the other is killed with
signal 9: every kind in turn, then whoever chance names. Its keeper starts each again, as a service manager
does. In the end all orders must be delivered, and the judgement is over what histories, database and floor
hold. The baseline is the same fleet before the first kill.

    campaign     what is done, on a fleet, with a customer and a watch
    victims      who is next
    history      all that agents have told
    judgement    what must not be
    works, cost  what became of the victims' work
"""

from __future__ import annotations

import asyncio
import shutil
import tempfile
from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from statistics import median, quantiles

from dray.cli.customers import HEAD_START_S, LOAD
from dray.cli.fleet.keeper import REST_S
from dray.errors import UnavailableError
from dray.plant import default_plant
from dray_sim.bench.losses.campaign import Campaign, Outcome, play
from dray_sim.bench.losses.cost import Kill, fates
from dray_sim.bench.losses.judgement import Finding, judge
from dray_sim.bench.losses.victims import Kind
from dray_sim.bench.losses.works import Works
from dray_sim.bench.row import Row

CALM = "nobody is killed"

QUICK = 10
"""A quick run has a tenth of the kills."""

P95 = 18
"""Its place among the cuts of twenty equal parts."""

HOUR_S = 3600.0


def measure(quick: bool) -> list[Row]:
    """Kill, and see what is lost.

    Args:
        quick: a tenth of the kills.

    Returns:
        The figures. When something was found that must not be, the fleet's folder stays, to be looked into.

    Raises:
        UnavailableError: the fleet does not start, or too little was carried to tell anything.
    """
    share = QUICK if quick else 1
    campaign = Campaign(
        plant=default_plant(),
        speed=10.0,
        plain=False,
        load=LOAD,
        head_start_s=HEAD_START_S,
        warm_s=60.0,
        calm_s=120.0 / (2 if quick else 1),
        each=10 // share,
        kills=200 // share,
        pause_s=2.5,
        down=3,
        drain_s=600.0,
        seed=1,
    )
    folder = Path(tempfile.mkdtemp(prefix="dray-losses-"))
    found = rows(asyncio.run(play(campaign, folder)))
    if all(row.met for row in found):
        shutil.rmtree(folder)
        return found
    return [row if row.met else replace(row, note=f"{row.note}; see {folder}") for row in found]


def rows(outcome: Outcome) -> list[Row]:
    """The figures of a campaign.

    Raises:
        UnavailableError: too little was carried to tell anything.
    """
    works = Works(outcome.after.history.events)
    calm_s, killing_s = works.durations_s(*outcome.calm_s), works.durations_s(*outcome.killing_s)
    if min(len(calm_s), len(killing_s)) < 2:
        reason = f"{len(calm_s)} transports while {CALM}, {len(killing_s)} after that"
        raise UnavailableError("the benchmark", reason, "let it run for longer")
    return [
        *map(_finding, judge(outcome.after)),
        _flow(outcome, len(killing_s), len(calm_s)),
        Row("losses: half of all transports", median(killing_s), "s", median(calm_s), CALM),
        Row("losses: 95 of 100 transports", _p95(killing_s), "s", _p95(calm_s), CALM),
        _punctuality(outcome),
        *(row for kind in Kind for row in _kind(kind, outcome.kills, works, median(calm_s))),
    ]


def _finding(finding: Finding) -> Row:
    note = "; ".join(finding.seen) or f"of {finding.of:,}"
    return Row(
        f"losses: {finding.what}", len(finding.seen), "", finding.of, finding.of_what, 0.0, note, less=True
    )


def _flow(outcome: Outcome, killing: int, calm: int) -> Row:
    """Transports that were delivered while everybody was killed, and while nobody was."""
    figure, baseline = (
        count * HOUR_S / (until_s - since_s)
        for count, (since_s, until_s) in ((killing, outcome.killing_s), (calm, outcome.calm_s))
    )
    since_s, until_s = outcome.killing_s
    note = f"a kill every {(until_s - since_s) / len(outcome.kills):.0f} s of the plant"
    return Row("losses: transports in an hour of the plant", figure, "1/h", baseline, CALM, note=note)


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


def _kind(kind: Kind, kills: Sequence[Kill], works: Works, calm_s: float) -> Iterable[Row]:
    """What it costs to lose one of this kind."""
    of_kind = [kill for kill in kills if kill.victim.kind is kind]
    away_s = [kill.away_s for kill in of_kind if kill.away_s is not None]
    if not away_s:
        return
    note = f"{len(of_kind)} killed; at most {max(away_s):.1f} s; {_told(of_kind, works)}".removesuffix("; ")
    yield Row(f"losses: {kind}, away", median(away_s), "s", REST_S, "the rest before a start", note=note)
    took_s = [
        span.took_s
        for kill in of_kind
        for task in kill.victim.work
        if (span := works.transports.get(task)) is not None and span.took_s is not None
    ]
    if took_s:
        note = f"at most {max(took_s):.0f} s"
        yield Row(f"losses: transport of a {kind}", median(took_s), "s", calm_s, CALM, note=note)


def _told(kills: Sequence[Kill], works: Works) -> str:
    """What became of their work, and after how many seconds of the plant."""
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
