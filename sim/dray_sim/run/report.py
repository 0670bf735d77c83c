"""The report of a run: figures as data, and the same figures for a reader."""

from __future__ import annotations

import msgspec

from dray.messages import MachineStatus
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.people.demand import Order
from dray_sim.run.evidence import HELD
from dray_sim.run.observer import Observer, percentile
from dray_sim.run.shortfall import Shortfall
from dray_sim.run.verdict import Verdict, judge


class Report(msgspec.Struct, frozen=True):
    """The figures of a run. Shares are parts of 1; times are factory seconds."""

    scenario: str
    seed: int
    duration_s: float
    orders_placed: int
    orders_due: int
    """Placed orders whose time was up before the end."""
    orders_delivered: int
    on_time_frac: float
    """Fraction of the due orders that were on time."""
    pieces_delivered: int
    transports: int
    transport_p50_s: float
    transport_p95_s: float
    late_p50_s: float
    """Real handover less the carrier's promise."""
    late_p95_s: float
    starvation_frac: float
    """Fraction of the machines' time with work in which material was missing."""
    machine_frac: dict[str, float]
    """The machines' time by status."""
    empty_travel_frac: float
    """Fraction of all metres."""
    utilisation_frac: dict[str, float]
    """The vehicles' time by activity."""
    bids_per_task: float
    rounds_per_task: float
    messages_per_task: float
    """Messages of the negotiation, without heartbeats and history."""
    watches_taken: int
    watches_lost: int
    answers: dict[str, int]
    """Results of awards."""
    refusals: dict[str, int]
    """Why vehicles did not bid."""
    messages: int
    deliveries: int
    invariants: str
    """`held`, or the broken invariant."""
    trace: str
    """The fingerprint of everything that was said."""
    verdict: Verdict
    """The bottleneck."""

    @property
    def failure(self) -> str:
        """The failure; empty when all held."""
        return "" if self.invariants == HELD else self.invariants

    def describe(self) -> str:
        """The figures for a reader."""
        return describe(self)

    def document(self) -> str:
        """The figures as a section of a Markdown document."""
        return f"## {self.scenario}\n\n```\n{self.describe()}\n```"


def make_report(
    scenario: str,
    *,
    seed: int,
    demand: list[Order],
    factory: SimFactory,
    observer: Observer,
    shortfall: Shortfall,
    invariants: str,
    trace: str,
) -> Report:
    """Gather a report at the present moment of a run."""
    now_s = factory.clock.now_s()
    observer.close(now_s)
    due = [order for order in demand if order.due_s <= now_s]
    on_time = [order for order in due if observer.fulfilled_s.get(order.id, now_s) < order.due_s]
    placed, on_time_frac = sum(order.at_s <= now_s for order in demand), _part(len(on_time), len(due))
    took_s, late_s = observer.took_s, observer.late_s
    tasks = max(1, len(took_s))
    return Report(
        scenario=scenario,
        seed=seed,
        duration_s=now_s,
        orders_placed=placed,
        orders_due=len(due),
        orders_delivered=len(observer.fulfilled_s),
        on_time_frac=on_time_frac,
        pieces_delivered=sum(observer.delivered.values()),
        transports=len(took_s),
        transport_p50_s=percentile(took_s, 0.5),
        transport_p95_s=percentile(took_s, 0.95),
        late_p50_s=percentile(late_s, 0.5),
        late_p95_s=percentile(late_s, 0.95),
        starvation_frac=_starvation(observer),
        machine_frac=_machine_frac(factory, observer, now_s),
        empty_travel_frac=_empty_travel(factory),
        utilisation_frac=_utilisation(factory),
        bids_per_task=observer.bids / tasks,
        rounds_per_task=observer.rounds / tasks,
        messages_per_task=observer.negotiation / tasks,
        watches_taken=observer.watches_taken,
        watches_lost=observer.watches_lost,
        answers=dict(sorted(observer.answers.items())),
        refusals=dict(sorted(observer.refusals.items())),
        messages=observer.messages,
        deliveries=factory.bus.delivered,
        invariants=invariants,
        trace=trace,
        verdict=judge(
            factory.plant,
            shortfall,
            placed=placed,
            delivered=len(observer.fulfilled_s),
            due=len(due),
            on_time_frac=on_time_frac,
        ),
    )


def describe(report: Report) -> str:
    """The report for a reader; the same bytes for the same run."""
    lines = [
        f"{report.scenario}, seed {report.seed}: {_clock(report.duration_s)} of factory time",
        "",
        _line("orders delivered", f"{report.orders_delivered} of {report.orders_placed} placed"),
        _line("on time", f"{report.on_time_frac:.1%} of {report.orders_due} that were due"),
        _line("pieces delivered", f"{report.pieces_delivered}"),
        _line("transports", f"{report.transports}"),
        _line("transport p50 / p95", f"{report.transport_p50_s:.0f} s / {report.transport_p95_s:.0f} s"),
        _line("later than promised p50 / p95", f"{report.late_p50_s:+.1f} s / {report.late_p95_s:+.1f} s"),
        _line("machines starving", f"{report.starvation_frac:.2%} of their time with work"),
        _line("machines' time", _shares(report.machine_frac)),
        _line("vehicles' time", _shares(report.utilisation_frac)),
        _line("empty travel", f"{report.empty_travel_frac:.1%} of all metres"),
        _line("bids / rounds per transport", f"{report.bids_per_task:.1f} / {report.rounds_per_task:.2f}"),
        _line("negotiation per transport", f"{report.messages_per_task:.0f} messages"),
        _line("watches taken / lost", f"{report.watches_taken} / {report.watches_lost}"),
        _line("awards", _counts(report.answers)),
        _line("refusals", _counts(report.refusals)),
        _line("messages said / delivered", f"{report.messages} / {report.deliveries}"),
        _line("invariants", report.invariants),
        _line("trace", report.trace),
        "",
        *report.verdict.lines(),
    ]
    return "\n".join(lines)


def _starvation(observer: Observer) -> float:
    spent = [times.spent_s for times in observer.machines.values()]
    starved_s = sum(each.get(MachineStatus.STARVED, 0.0) for each in spent)
    idle = (MachineStatus.IDLE, MachineStatus.ERROR, MachineStatus.RESTING)
    busy_s = sum(s for each in spent for status, s in each.items() if status not in idle)
    return _part(starved_s, busy_s)


def _machine_frac(factory: SimFactory, observer: Observer, now_s: float) -> dict[str, float]:
    whole_s = now_s * len(factory.workcells)
    spent_s = dict.fromkeys((status.value for status in MachineStatus), 0.0)
    for times in observer.machines.values():
        for status, s in times.spent_s.items():
            spent_s[status.value] += s
    # A machine that never changed its status was idle all the time.
    spent_s[MachineStatus.IDLE.value] += whole_s - sum(spent_s.values())
    return {status: _part(s, whole_s) for status, s in spent_s.items()}


def _empty_travel(factory: SimFactory) -> float:
    odometers = [vehicle.odometer() for vehicle in factory.vehicles.values()]
    empty_m = sum(each.empty_m for each in odometers)
    return _part(empty_m, empty_m + sum(each.loaded_m for each in odometers))


def _utilisation(factory: SimFactory) -> dict[str, float]:
    spent_s: dict[str, float] = {}
    for vehicle in factory.vehicles.values():
        for activity, s in vehicle.odometer().seconds.items():
            spent_s[activity] = spent_s.get(activity, 0.0) + s
    whole_s = sum(spent_s.values())
    return {activity: _part(s, whole_s) for activity, s in spent_s.items()}


def _part(part: float, whole: float) -> float:
    return part / whole if whole else 0.0


def _line(name: str, value: str) -> str:
    return f"  {name:<30} {value}"


def _shares(shares: dict[str, float]) -> str:
    return ", ".join(f"{name} {share:.1%}" for name, share in shares.items())


def _counts(counts: dict[str, int]) -> str:
    return ", ".join(f"{name} {count}" for name, count in counts.items()) or "none"


def _clock(duration_s: float) -> str:
    hours, rest_s = divmod(round(duration_s), 3600)
    return f"{hours} h {rest_s // 60:02} min"
