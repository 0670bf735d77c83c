"""The factory's figures over time: joins minute samples into steps of any length. Pure."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby

import msgspec

from dray.gateway.factory.figure_sampler import SAMPLE_S
from dray.store.factory.kpis import KpiSample


class KpiPoint(msgspec.Struct, frozen=True, kw_only=True):
    """One step. Unknown figures are null; times are factory seconds except `at_s`."""

    at_s: float
    """Begin of the step, wall clock."""
    span_s: float
    """Factory seconds observed: less where the gateway was away."""
    orders_delivered: int
    on_time_frac: float | None
    """Fraction of these orders."""
    starved_frac: float | None
    """Fraction of the machines' time with a goal in which material was missing."""
    transports: int
    """Transports handed over."""
    transports_per_hour: float | None
    transport_p50_s: float | None
    """From announcement to handover, over the 200 transports before the step's end."""
    transport_p95_s: float | None
    empty_frac: float | None
    """Fraction of the fleet's way driven without a load."""
    moving_frac: float | None
    """Fraction of the fleet's time, like the five below; together they are 1."""
    waiting_frac: float | None
    charging_frac: float | None
    blocked_frac: float | None
    idle_frac: float | None
    silent_frac: float | None
    out_of_service_frac: float | None
    """Fraction of all vehicles' time, by a person's word; not part of the fleet's time otherwise."""
    atv_available_frac: float | None
    """Fraction of the vehicles' time in service in which they were heard and neither stopped nor in error."""
    machine_available_frac: float | None
    """Fraction of the machines' time in which they were heard and not in error."""
    commands: int
    """Commands that vehicles obeyed."""
    helps: int
    """Calls for help by vehicles."""
    energy_wh: float
    """Energy taken from vehicles' batteries, by their gauges."""


class KpiHistory(msgspec.Struct, frozen=True, kw_only=True):
    """The factory's figures over time."""

    since_at_s: float
    """Wall clock; a whole number of steps before `until_at_s`."""
    until_at_s: float
    step_s: float
    """Wall seconds."""
    items: tuple[KpiPoint, ...]
    """Oldest first, without unobserved steps."""


def points(samples: Iterable[KpiSample], step_s: float) -> Iterator[KpiPoint]:
    """Join samples into steps.

    Args:
        samples: oldest first.
        step_s: length of a step in wall seconds; steps begin at whole multiples of it.
    """
    for number, of_step in groupby(samples, lambda sample: _middle_s(sample) // step_s):
        yield point(number * step_s, list(of_step))


def _middle_s(sample: KpiSample) -> float:
    """The middle of a sample's minute, since it is written just after that minute."""
    return sample.at_s - SAMPLE_S / 2


def point(at_s: float, samples: Sequence[KpiSample]) -> KpiPoint:
    """All samples as one step.

    Args:
        at_s: begin of the step, wall clock.
        samples: one or more, oldest first.
    """

    def total(*names: str) -> float:
        return float(sum(getattr(sample, name) for sample in samples for name in names))

    atv = {doing: total(f"atv_{doing}_s") for doing in FLEET}
    fleet_s, out_s = sum(atv.values()), total("atv_out_of_service_s")
    up_s = total("machine_making_s", "machine_starved_s", "machine_idle_s")
    machines_s = up_s + total("machine_broken_s", "machine_down_s", "machine_silent_s")
    with_goal_s = total("machine_making_s", "machine_starved_s", "machine_broken_s")
    span_s, transports = total("span_s"), total("transports")
    return KpiPoint(
        at_s=at_s,
        span_s=span_s,
        orders_delivered=int(total("orders_delivered")),
        on_time_frac=part(total("orders_on_time"), total("orders_delivered")),
        starved_frac=part(total("machine_starved_s"), with_goal_s),
        transports=int(transports),
        transports_per_hour=part(transports * 3600.0, span_s),
        transport_p50_s=samples[-1].transport_p50_s,
        transport_p95_s=samples[-1].transport_p95_s,
        empty_frac=part(total("empty_m"), total("empty_m", "loaded_m")),
        moving_frac=part(atv["moving"], fleet_s),
        waiting_frac=part(atv["waiting"], fleet_s),
        charging_frac=part(atv["charging"], fleet_s),
        blocked_frac=part(atv["blocked"], fleet_s),
        idle_frac=part(atv["idle"], fleet_s),
        silent_frac=part(atv["silent"], fleet_s),
        out_of_service_frac=part(out_s, fleet_s + out_s),
        atv_available_frac=part(fleet_s - atv["blocked"] - atv["silent"], fleet_s),
        machine_available_frac=part(up_s, machines_s),
        commands=int(total("commands")),
        helps=int(total("helps")),
        energy_wh=total("energy_wh"),
    )


FLEET = ("moving", "waiting", "charging", "blocked", "idle", "silent")


def part(some: float, whole: float) -> float | None:
    """A fraction; None if the whole is 0."""
    return some / whole if whole > 0 else None
