"""The factory's figures over time: samples of minutes put together to steps of any length. Pure."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby

import msgspec

from dray.gateway.factory.figure_sampler import SAMPLE_S
from dray.store.factory.kpis import KpiSample


class KpiPoint(msgspec.Struct, frozen=True, kw_only=True):
    """One step. Figures that nothing tells of are null; times are factory seconds but for `at_s`."""

    at_s: float
    """Its beginning, wall clock."""
    span_s: float
    """Factory seconds that were seen of it: less where the gateway was away."""
    orders_delivered: int
    on_time_frac: float | None
    """Of these orders."""
    starved_frac: float | None
    """Part of the machines' time with a goal in which material was missing."""
    transports: int
    """Handed over."""
    transports_per_hour: float | None
    transport_p50_s: float | None
    """From announcement to handover, over the 200 transports before its end."""
    transport_p95_s: float | None
    empty_frac: float | None
    """Part of the fleet's way that was driven without a load."""
    moving_frac: float | None
    """Of the fleet's time, as the five below: together they are 1."""
    waiting_frac: float | None
    charging_frac: float | None
    blocked_frac: float | None
    idle_frac: float | None
    silent_frac: float | None
    out_of_service_frac: float | None
    """Of all their time, by a person's word; it is no part of the fleet's time otherwise."""
    atv_available_frac: float | None
    """Part of the vehicles' time in service in which they were heard and neither stopped nor in error."""
    machine_available_frac: float | None
    """Part of the machines' time in which they were heard and not in error."""
    commands: int
    """People's commands that vehicles have obeyed."""
    helps: int
    """How often vehicles have asked for help."""
    energy_wh: float
    """Taken from vehicles' batteries, by what these show."""


class KpiHistory(msgspec.Struct, frozen=True, kw_only=True):
    """The factory's figures over time."""

    since_at_s: float
    """Wall clock, as `until_at_s`: a whole number of steps lies between the two."""
    until_at_s: float
    step_s: float
    """Wall seconds."""
    items: tuple[KpiPoint, ...]
    """Oldest first; steps of which nothing was seen are left out."""


def points(samples: Iterable[KpiSample], step_s: float) -> Iterator[KpiPoint]:
    """Put samples together.

    Args:
        samples: oldest first.
        step_s: the length of a step in wall seconds; steps begin at whole multiples of it.
    """
    for number, of_step in groupby(samples, lambda sample: _middle_s(sample) // step_s):
        yield point(number * step_s, list(of_step))


def _middle_s(sample: KpiSample) -> float:
    """Where a sample belongs: it is written a moment after its minute."""
    return sample.at_s - SAMPLE_S / 2


def point(at_s: float, samples: Sequence[KpiSample]) -> KpiPoint:
    """All of these in one step.

    Args:
        at_s: its beginning, wall clock.
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
    """A part of a whole; None of nothing."""
    return some / whole if whole > 0 else None
