"""Warnings about a valid plant file: shortages, each with a figure and a remedy.

Faults (`dray.plant.file.check`) say that a plant cannot be run at all. A warning says that it can be run, and with
which limits. It names the resource that is full before the machines are (`dray.plant.planning.flow`), a vehicle that
cannot be replaced, a trap, or a floor that is too narrow for the vehicles (`dray.plant.planning.advice_floor`).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import msgspec

from dray.plant.file.reasons import Reason, counted, joined, listed
from dray.plant.floor.sizes import too_large_for
from dray.plant.model import Material, Product
from dray.plant.planning.advice_floor import floor_advice
from dray.plant.planning.flow import Flow, Limit
from dray.plant.planning.room import ERRORS
from dray.plant.plant import Plant

GOOD_LOAD_FRAC = 0.85
"""Load of a good day, as a part of the machines' time. A resource that is full below it gets a warning."""

MACHINE_LOAD_FRAC = 0.5
"""Lowest load of machines without a warning: unequal numbers of machines per product are no fault, but below this
they are."""

MOST_OF_A_KIND = 3
"""Most warnings of one kind; a planner with more solves these first."""

KEPT_FRAC = 0.25
"""Battery level above which a vehicle stops for the queue at the chargers earlier than by the usual rules
(`Charging.must_below_frac`)."""

NO_LOAD_FRAC = 0.005
"""Below this a plant cannot be served at all."""

FIELDS = {
    "machine": "machines",
    "buffer": "materials",
    "dock": "machines",
    "material": "storages",
    "vehicles": "fleet",
    "charger": "chargers",
}


class Advice(msgspec.Struct, frozen=True):
    """One warning."""

    kind: str
    """dwell_points, charger, queue, material, dock, buffer, machine, vehicles, range, alone, trap, uncounted, large, near, narrow, touch,
    crossing, way or door."""
    field: str
    """The section of the plant file."""
    text: Reason
    """The shortage, a figure, and the remedy."""
    load_frac: float = 1.0
    """The load (part of the machines' time) at which it is full; 1 where it is none of that."""
    level: Literal["warning", "error"] = "warning"
    """An error: with right of way the plant cannot work as it is drawn."""
    about: tuple[tuple[str, ...], ...] = ()
    """The nodes that a warning of the floor is about, each entry one place that is too narrow."""


def advice(plant: Plant, load_frac: float | None = None) -> list[Advice]:
    """All warnings of a plant; none for one in which nothing is short.

    Args:
        plant: without faults.
        load_frac: part of the machines' time that orders will take; a resource that is full below it is an error.
            None where it is unknown.
    """
    flow = Flow(plant)
    found = [
        *_dwell_points(plant),
        *_ranges(flow),
        *_queue(plant),
        *_limits(plant, flow, load_frac),
        *_alone(plant),
        *_traps(plant),
        *_floor(plant),
        *_uncounted(plant),
        *_large(plant),
    ]
    if load_frac is None:
        return found
    return [_asked(each, load_frac) if each.load_frac < load_frac else each for each in found]


def _asked(warning: Advice, load_frac: float) -> Advice:
    """Make an error of a resource that is full below the load of the orders."""
    text = Reason("asked_load", text=warning.text, load_pct=100.0 * load_frac)
    return msgspec.structs.replace(warning, level="error", text=text)


def _floor(plant: Plant) -> Iterator[Advice]:
    for kind, field, text, about in floor_advice(plant):
        yield Advice(kind, field, text, level="error" if kind in ERRORS else "warning", about=about)


def most_vehicles(plant: Plant) -> int:
    """How many vehicles of its fleet find a place without work, be it in somebody's way."""
    return min(len(plant.fleet), len(plant.dwell_points) + len(plant.spare_places.all))


def _dwell_points(plant: Plant) -> Iterator[Advice]:
    dwell_points, fleet, spare = len(plant.dwell_points), len(plant.fleet), plant.spare_places
    missing = fleet - dwell_points
    if missing <= 0:
        return
    wait = [Reason("waits_on_roads", count=missing)]
    if spare.reserve:
        wait.append(Reason("waits_reserve", count=len(spare.reserve) + len(spare.shut)))
    if spare.others:
        wait.append(Reason("waits_in_way", count=len(spare.others)))
    most = most_vehicles(plant)
    homeless = fleet - most
    if homeless:
        wait.append(Reason("waits_nowhere", count=homeless, most=most))
    text = Reason(
        "dwell_points",
        places=dwell_points,
        chargers=len(plant.chargers),
        parkings=len(plant.parkings),
        vehicles=fleet,
        waits=tuple(wait),
        add=counted("add_parking", "add_parkings", missing),
        away=counted("or_away", "or_away_many", homeless) if homeless else "",
    )
    yield Advice("dwell_points", "parkings", text, level="error" if homeless else "warning")


def _uncounted(plant: Plant) -> Iterator[Advice]:
    """Docks that do not count: the vehicles' reports are believed there."""
    blind = [spec.id for spec in plant.machines.values() if not spec.counts]
    if blind:
        text = Reason(
            "uncounted",
            count=len(blind),
            machines=len(plant.machines),
            names=tuple(blind[:MOST_OF_A_KIND]),
        )
        yield Advice("uncounted", "machines", text)


def _large(plant: Plant) -> Iterator[Advice]:
    """Types of the fleet that are too large for some nodes, and avoid these."""
    driving = {vehicle.type for vehicle in plant.fleet.values()}
    for kind in plant.vehicle_types.values():
        nodes = too_large_for(plant.file, kind)
        if nodes and kind.id in driving:
            text = Reason(
                "large",
                type=kind.id,
                length_m=kind.length_m,
                width_m=kind.width_m,
                nodes=listed(nodes, MOST_OF_A_KIND),
            )
            yield Advice("large", "nodes", text, about=tuple((node,) for node in nodes))


def _ranges(flow: Flow) -> Iterator[Advice]:
    """A transport that takes more than a battery holds; an error if no vehicle can ever carry it."""
    never = next((stream for stream in flow.streams if stream.least_frac > 1.0), None)
    if never is not None:
        text = Reason(
            "range_never",
            item=never.item,
            source=never.source,
            destination=never.destination,
            takes_pct=100.0 * never.least_frac,
        )
        yield Advice("range", "vehicle_types", text, 0.0, level="error")
        return
    for stream in flow.streams:
        if stream.dearest_frac > stream.usable_frac:
            text = Reason(
                "range",
                item=stream.item,
                source=stream.source,
                destination=stream.destination,
                takes_pct=100.0 * stream.dearest_frac,
                usable_pct=100.0 * stream.usable_frac,
            )
            yield Advice("range", "vehicle_types", text, 0.0)
            return


def _queue(plant: Plant) -> Iterator[Advice]:
    """A type of vehicle that keeps much of its battery for the wait at the chargers, and carries the less."""
    queue = plant.charger_queue
    kind = max(sorted({spec.type for spec in plant.fleet.values()}), key=queue.base_frac)
    if queue.base_frac(kind) > KEPT_FRAC:
        text = Reason(
            "charger_queue",
            chargers=len(plant.chargers),
            vehicles=len(plant.fleet),
            type=kind,
            left_pct=100.0 * queue.base_frac(kind),
            wait_s=queue.wait_s,
            ahead=counted("others_one", "others_many", queue.ahead),
        )
        yield Advice("queue", "chargers", text)


def _limits(plant: Plant, flow: Flow, load_frac: float | None) -> Iterator[Advice]:
    counts: dict[str, int] = {}
    limits = flow.limits()
    fleet_frac = min((limit.load_frac for limit in limits if limit.kind == "vehicles"), default=1.0)
    for limit in limits:
        if limit.kind == "charger" and limit.load_frac > fleet_frac:
            # The fleet is full before it could use so much.
            continue
        least = MACHINE_LOAD_FRAC if limit.kind == "machine" else GOOD_LOAD_FRAC
        if load_frac is not None:
            least = max(least, load_frac)
        counts[limit.kind] = counts.get(limit.kind, 0) + 1
        if limit.load_frac >= least or counts[limit.kind] > MOST_OF_A_KIND:
            continue
        field = "storages" if limit.kind == "dock" and limit.name in plant.storages else FIELDS[limit.kind]
        yield Advice(limit.kind, field, _text(limit), limit.load_frac)


def _text(limit: Limit) -> Reason:
    """The limit in words."""
    if limit.load_frac < NO_LOAD_FRAC and limit.kind == "charger":
        return Reason("limit_no_energy", name=limit.name, remedy=limit.remedy)
    return Reason(
        f"limit_{limit.kind}",
        name=limit.name,
        asks=limit.asks,
        load_pct=100.0 * limit.load_frac,
        remedy=limit.remedy,
    )


def _alone(plant: Plant) -> Iterator[Advice]:
    """An ability of one vehicle only: no other vehicle can watch it or take over."""
    items: dict[str, Material | Product] = {**plant.materials, **plant.products}
    for ability in plant.abilities:
        able = plant.able(ability)
        if len(able) == 1:
            carried = [item.id for item in items.values() if item.ability == ability]
            text = Reason(
                "alone",
                vehicle=able[0],
                vehicles=len(plant.fleet),
                ability=ability,
                items=listed(carried),
                type=plant.fleet[able[0]].type,
            )
            yield Advice("alone", "fleet", text)


def _traps(plant: Plant) -> Iterator[Advice]:
    """Nodes that vehicles cannot leave, or reach; and docks that places share."""
    home = plant.node_of(next(iter(plant.machines)))
    reached, reaching = plant.roads.reached_from(home), plant.roads.reaching(home)
    trapped = [node for node in plant.nodes if node in reached and node not in reaching]
    lost = [node for node in plant.nodes if node not in reached]
    for nodes, code in ((trapped, "trapped"), (lost, "lost")):
        if nodes:
            yield Advice("trap", "nodes", Reason(code, nodes=listed(nodes)))
    docks: dict[str, list[str]] = {}
    for place in (*plant.machines, *plant.storages, *plant.warehouses, *plant.dwell_points):
        docks.setdefault(plant.node_of(place), []).append(place)
    for node, places in docks.items():
        if len(places) > 1:
            yield Advice("trap", "nodes", Reason("one_dock", places=joined("and", places), node=node))
