"""The verdict on a run: its bottleneck, the remedy, and a figure for each resource."""

from __future__ import annotations

from typing import Any

import msgspec

from dray.messages import MachineStatus
from dray.overload import WAITED_S
from dray.plant import Plant
from dray.plant.file.reasons import Reason, told
from dray_sim.run.shortfall import Cause, Shortfall

SERVED_FRAC = 0.95
"""Fraction of the due orders on time; above it, and with little lost time, there is no bottleneck."""

LOST_FRAC = 0.05
"""Fraction of the time of machines with work."""

FULL_FRAC = 0.85
"""Fraction of its time in which a machine made pieces: it has none left."""

LEFT_FRAC = 0.5
"""Fraction of the run's time: a machine with so much work left at the end was given more than it can make."""

WAIT_FRAC = 0.2
"""Fraction of the time of all transports."""

SHOWN_FRAC = 0.005
"""Least use and wait of a resource that is shown."""

TOLD = 3
"""Resources of a kind that are named."""

NOTHING = "nothing"


class Resource(msgspec.Struct, frozen=True):
    """The use of one resource. Shares are parts of 1."""

    kind: str
    """vehicles, charger, machine, material, dock, lane or buffer."""
    name: str
    busy_frac: float
    """Fraction of its time; for a material, the time in which no storage had a container of it. A dock may have more
    than 1 in a simulation where vehicles do not exclude each other: that many docks would be needed."""
    waiting_frac: float
    """Fraction of the time of all transports in which they waited for it."""
    lost_frac: float
    """Fraction of the time of machines with work that they lost because of it."""


class Verdict(msgspec.Struct, frozen=True):
    """The bottleneck of a run."""

    bottleneck: str
    """A kind of resource, or `nothing`."""
    name: str
    """Id of the resource; empty for none."""
    text: str
    """In words: the scarce resource, the symptom and the remedy; and how long the plant was overloaded."""
    code: str
    """Code of the text, by `dray.plant.file.reasons`, so that panels show it in the reader's language."""
    values: dict[str, Any]
    """Values for the text."""
    overloaded_frac: float
    """Fraction of the time, by the rule of the alert `overloaded`."""
    overloaded_waiting: int
    """Transports that had waited too long for a vehicle, when there were most of them."""
    resources: tuple[Resource, ...]
    """The scarcest of every kind."""

    def lines(self) -> list[str]:
        """Lines for a reader."""
        shown = [f"  {'verdict':<30} {self.text}"]
        for each in self.resources:
            figures = [f"{_busy(each)} {each.busy_frac:.0%}"]
            if each.waiting_frac >= SHOWN_FRAC:
                figures.append(f"transports waited {each.waiting_frac:.0%} of their time for it")
            if each.lost_frac >= SHOWN_FRAC:
                figures.append(f"machines lost {each.lost_frac:.0%} of theirs")
            shown.append(f"    {each.kind + ' ' + each.name:<40} {', '.join(figures)}")
        return shown


def judge(
    plant: Plant, seen: Shortfall, *, placed: int, delivered: int, due: int, on_time_frac: float
) -> Verdict:
    """Judge a run.

    Args:
        plant: the plant.
        seen: of the whole run.
        placed: orders.
        delivered: those of them that have arrived.
        due: those of them whose time was up.
        on_time_frac: of the orders that were due.
    """
    found = sorted(
        _resources(plant, seen), key=lambda each: (-each.lost_frac, -each.waiting_frac, -each.busy_frac)
    )
    kept: list[Resource] = []
    for each in found:
        shown = (
            each.busy_frac >= SHOWN_FRAC or each.waiting_frac >= SHOWN_FRAC or each.lost_frac >= SHOWN_FRAC
        )
        if shown and sum(other.kind == each.kind for other in kept) < TOLD:
            kept.append(each)
    left_frac = max(seen.left_s.values(), default=0.0) / max(seen.looked_s, 1.0)
    on_time = not due or on_time_frac >= SERVED_FRAC
    short = _bottleneck(found, on_time=on_time, left=left_frac >= LEFT_FRAC)
    kind, name = (NOTHING, "") if short is None else (short.kind, short.name)
    text = (
        _nothing(found, placed, delivered, due, on_time_frac)
        if short is None
        else _too_few(plant, seen, short)
    )
    overloaded_frac = seen.overloaded_s / max(seen.looked_s, 1.0)
    text = _overloaded(text, overloaded_frac, seen.overloaded_waiting)
    return Verdict(
        bottleneck=kind,
        name=name,
        text=str(text),
        code=text.code,
        values=told(text, str),
        overloaded_frac=overloaded_frac,
        overloaded_waiting=seen.overloaded_waiting,
        resources=tuple(kept),
    )


def _bottleneck(found: list[Resource], *, on_time: bool, left: bool) -> Resource | None:
    """The resource for which everything waits; None without a bottleneck."""
    lost = sum(each.lost_frac for each in found)
    full = max(
        (each for each in found if each.kind == "machine"), key=lambda each: each.busy_frac, default=None
    )
    dock = max((each for each in found if each.kind == "dock"), key=lambda each: each.busy_frac, default=None)
    waited = max(found, key=lambda each: each.waiting_frac)
    if full is not None and full.busy_frac < FULL_FRAC:
        full = None
    worst = found[0]
    # Scattered losses of machines are small beside a machine without any time left. A late load is the fault of a
    # dock at which several vehicles would have to stand.
    if lost >= LOST_FRAC and (full is None or worst.lost_frac >= 2 * LOST_FRAC) and worst.kind != "buffer":
        return worst
    if dock is not None and dock.busy_frac > 1.0:
        return dock
    if lost >= LOST_FRAC and full is None:
        return worst
    if full is not None and (not on_time or left):
        return full
    return waited if not on_time and waited.waiting_frac >= WAIT_FRAC else None


def _resources(plant: Plant, seen: Shortfall) -> list[Resource]:
    looked_s = max(seen.looked_s, 1.0)
    with_work_s = sum(
        seconds
        for spent in seen.machine_s.values()
        for status, seconds in spent.items()
        if status not in (MachineStatus.IDLE, MachineStatus.ERROR, MachineStatus.RESTING)
    )

    def resource(cause: Cause, busy_frac: float) -> Resource:
        return Resource(
            *cause,
            busy_frac=busy_frac,
            waiting_frac=seen.wait_s.get(cause, 0.0) / max(seen.open_s, 1.0),
            lost_frac=seen.lost_s.get(cause, 0.0) / max(with_work_s, 1.0),
        )

    found = [
        resource(("machine", machine), spent.get(MachineStatus.PRODUCING, 0.0) / looked_s)
        for machine, spent in seen.machine_s.items()
    ]
    found.append(resource(("charger", "all"), sum(seen.charging_s.values()) / looked_s / len(plant.chargers)))
    for ability in plant.abilities:
        able = plant.able(ability)
        busy_s = sum(seen.working_s.get(atv, 0.0) for atv in able)
        found.append(resource(("vehicles", ability), busy_s / looked_s / len(able)))
    found += [
        resource(("material", material), seen.empty_s.get(material, 0.0) / looked_s)
        for material in plant.materials
    ]
    docks = {place for kind, place in seen.wait_s if kind == "dock"} | set(seen.docked_s)
    found += [resource(("dock", place), seen.docked_s.get(place, 0.0) / looked_s) for place in sorted(docks)]
    others = {cause for cause in (*seen.wait_s, *seen.lost_s) if cause[0] in ("lane", "buffer")}
    found += [resource(cause, 0.0) for cause in sorted(others)]
    return found


# --- in words -------------------------------------------------------------------------------------------


def _busy(each: Resource) -> str:
    return {"material": "out of stock", "machine": "producing", "dock": "in use", "charger": "in use"}.get(
        each.kind, "at work"
    )


def _nothing(found: list[Resource], placed: int, delivered: int, due: int, on_time_frac: float) -> Reason:
    if due and on_time_frac < SERVED_FRAC:
        return Reason("played_late", on_time=_percent(on_time_frac), due=due)
    busiest = max(
        (each for each in found if each.kind in ("machine", "vehicles", "charger")),
        key=lambda each: each.busy_frac,
    )
    where = (
        Reason("played_all_chargers")
        if busiest.kind == "charger"
        else Reason(f"played_{busiest.kind}", name=busiest.name)
    )
    return Reason(
        "played_nothing_short",
        delivered=delivered,
        placed=placed,
        where=where,
        busy=_percent(busiest.busy_frac),
    )


def _overloaded(verdict: Reason, overloaded_frac: float, waiting: int) -> Reason:
    """The same, and for how long the plant was overloaded."""
    if not overloaded_frac:
        return verdict
    return Reason(
        "played_overloaded",
        verdict=verdict,
        time=100.0 * overloaded_frac,
        waiting=waiting,
        limit_min=WAITED_S / 60.0,
    )


def _too_few(plant: Plant, seen: Shortfall, short: Resource) -> Reason:
    busy, lost = _percent(short.busy_frac), _percent(short.lost_frac)
    cost = Reason("played_cost", waited=_percent(short.waiting_frac), lost=lost)
    looked_s = max(seen.looked_s, 1.0)
    match short.kind:
        case "vehicles":
            queue = seen.wait_s.get(("vehicles", short.name), 0.0) / looked_s
            count = len(plant.able(short.name))
            return Reason(
                "played_few_vehicles", ability=short.name, count=count, busy=busy, queue=queue, cost=cost
            )
        case "charger":
            return Reason(
                "played_few_chargers",
                chargers=len(plant.chargers),
                vehicles=len(plant.fleet),
                busy=busy,
                hungry=sum(seen.hungry_s.values()) / looked_s,
                cost=cost,
            )
        case "material":
            kept = tuple(
                f"{storage.id} {stock.capacity}"
                for storage in plant.storages.values()
                for stock in storage.stocks
                if stock.material == short.name
            )
            return Reason("played_little_material", item=short.name, busy=busy, kept=kept, cost=cost)
        case "machine":
            return Reason(
                "played_few_machines",
                products=tuple(making.product for making in plant.machines[short.name].makes),
                machine=short.name,
                busy=busy,
                left_h=seen.left_s.get(short.name, 0.0) / 3600.0,
            )
        case "dock":
            return Reason("played_few_docks", place=short.name, busy=busy, cost=cost)
        case "buffer":
            return Reason("played_small_buffer", item=short.name, lost=lost)
        case _:
            return Reason("played_narrow_lane", lane=short.name, cost=cost)


def _percent(frac: float) -> int:
    return round(100.0 * frac)
