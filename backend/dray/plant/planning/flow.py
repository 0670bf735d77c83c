"""The capacity of a plant: arithmetic over cycle times, containers, ways and batteries, before anything runs.

Demand is taken as the simulated one is: orders of all products equally often, of two containers each. At *load* 1
orders take all of the machines' time. Each place, vehicle and charger that carries or holds the material for that is
a *resource*, and is full at some load:

    limit = capacity / demand at load 1

The least limit of all resources is the load that the plant can bear. Queues are ignored: they grow before a resource
is full, so a plant should be run well below its limit.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

from dray.errors import NoWay
from dray.plant.charger_queue import CHANGEOVER_S
from dray.plant.file.reasons import Reason, counted, joined
from dray.plant.model import VehicleType
from dray.plant.plant import Plant

LOTS_PER_ORDER = 2.0
"""Mean number of containers of an order."""

PART_LOADS = 1.25
"""Containers of goods for one that would be full: the last one of an order seldom is."""

NEGOTIATION_S = 8.0
"""Time of a transport beside driving and handling: bidding, award, the questions at both docks."""

REFILL_S = 120.0
"""Time from a low stock of a storage to a full one: a tugger train that is about. The paper does not model this
transport (4.1), and neither does the plant file."""

CHARGER_SHARE = 0.7
"""Largest fraction of its time in which a charger gives full power: the rest is changing over, and the slow end of a
charge."""

USABLE_FRAC = 0.8
"""Fraction of a battery between the level at which a charge ends and the reserve that no promise may touch; less
where the queue at the chargers takes more (`dray.plant.charger_queue`)."""

SHARES = 40
"""Parts in which the work of a product is distributed among its machines: fine enough for a percent or two."""

MAX_STARTS = 12
"""Places from which the mean way to a source is taken; in a large plant every further one changes little."""

MAX_ABILITIES = 8
"""Abilities of which all combinations are looked at; beyond, each alone and all together."""


@dataclass(frozen=True, slots=True)
class Stream:
    """Containers that go one way, again and again.

    Attributes:
        item: material or product.
        source, destination: places.
        per_s: containers a second at load 1.
        took_s: a vehicle's time for one (s), the empty way to it included; the mean of the vehicles that can carry
            it.
        lead_s: from the announcement to the handover with a free vehicle.
        fetch_s: from the announcement until the load has left its source, likewise.
        energy_wh: Wh of a vehicle for one.
    """

    item: str
    source: str
    destination: str
    per_s: float
    took_s: float
    lead_s: float
    fetch_s: float
    energy_wh: float
    dearest_frac: float
    """Largest use of a vehicle's battery by it, relative to the usable part."""
    usable_frac: float
    """Usable part of that vehicle's battery."""
    least_frac: float
    """Part of a full battery for one from a charger over a source to a destination, with what must be left there. The
    first that is 1 at most; where there is none, the least of all vehicles and places."""


@dataclass(frozen=True, slots=True)
class Limit:
    """A resource, and the load at which it is full.

    Attributes:
        kind: machine, buffer, dock, material, vehicles or charger.
        name: of the resource, for people.
        load_frac: it is full at this load (part of all machines' time); 0 when it never suffices.
        asks: demand at load 1, relative to the capacity: 1 is just enough.
        remedy: of a shortage.
    """

    kind: str
    name: str
    load_frac: float
    remedy: Reason

    @property
    def asks(self) -> float:
        return 1.0 / self.load_frac if self.load_frac > 0.0 else float("inf")


class Flow:
    """The demand of load 1 on a plant.

    Args:
        plant: without faults.

    Attributes:
        busy: per machine and product, the part of the machine's time at load 1; above 1 where its
            products have too few machines.
        streams: all containers.
    """

    def __init__(self, plant: Plant) -> None:
        self.plant = plant
        self._kinds = {
            name: plant.vehicle_types[name] for name in sorted({v.type for v in plant.fleet.values()})
        }
        self._count = {name: sum(v.type == name for v in plant.fleet.values()) for name in self._kinds}
        self.busy = _deal_out(plant)
        self.streams = tuple(self._streams())

    # --- limits ---

    def limits(self) -> list[Limit]:
        """Every resource with its limit, the scarcest first."""
        found = (
            *self._machine_limits(),
            *self._buffer_limits(),
            *self._dock_limits(),
            *self._material_limits(),
            *self._vehicle_limits(),
            *self._charger_limits(),
        )
        return sorted(found, key=lambda limit: limit.load_frac)

    def bearable_load(self) -> float:
        """The load at which the first resource is full; machines themselves are at 1 at the latest."""
        return min(1.0, self.limits()[0].load_frac)

    def _machine_limits(self) -> Iterator[Limit]:
        for machine, shares in self.busy.items():
            busy = sum(shares.values())
            if busy > 0.0:
                most = max(shares, key=lambda product: shares[product])
                remedy = Reason("remedy_make", product=most)
                yield Limit("machine", machine, 1.0 / busy, remedy)

    def _buffer_limits(self) -> Iterator[Limit]:
        """The pieces in a buffer and on their way to it have to last as long as a transport takes."""
        plant = self.plant
        per_s = self._pieces_per_s()
        for stream in self.streams:
            if stream.destination in plant.machines:
                machine, material = stream.destination, plant.materials[stream.item]
                used = max(
                    line.quantity
                    for product in self.busy[machine]
                    for line in plant.products[product].bill
                    if line.material == stream.item
                )
                limit = max(material.buffer - used, 1) / (stream.lead_s * per_s[machine, stream.item])
                # Without material a machine waits; up to its idle time at this load that does no harm.
                remedy = Reason("remedy_buffer", item=stream.item, buffer=material.buffer)
                yield Limit("buffer", Reason("at", name=stream.item, place=machine), limit, remedy)
            elif stream.source in plant.machines:
                machine = stream.source
                room = plant.machines[machine].goods_capacity
                limit = room / (stream.lead_s * per_s[machine, stream.item])
                remedy = Reason("remedy_goods", room=room)
                yield Limit("buffer", Reason("from", name=stream.item, place=machine), limit, remedy)

    def _dock_limits(self) -> Iterator[Limit]:
        """One vehicle at a time stands at a dock, for its loading or unloading."""
        used: dict[str, float] = {}
        for stream in self.streams:
            load_s, unload_s = self._handling_s(stream.item)
            for place, takes_s in ((stream.source, load_s), (stream.destination, unload_s)):
                used[place] = used.get(place, 0.0) + stream.per_s * (takes_s + CHANGEOVER_S)
        for place, part in used.items():
            yield Limit("dock", place, 1.0 / part, Reason("remedy_dock"))

    def _material_limits(self) -> Iterator[Limit]:
        """A storage that fills itself gives its capacity once per refill; refills by vehicles count as transports.

        It orders the refill when loads have left it. Those that it has promised leave it when a vehicle has come.
        """
        plant = self.plant
        needed: dict[str, float] = {}
        fetched: dict[str, float] = {}
        """By item: time of its vehicles until its loads have left, per second."""
        for stream in self.streams:
            if stream.item in plant.materials.keys() - plant.parts and not self._refilled(stream.item):
                pieces_per_s = stream.per_s * plant.materials[stream.item].lot
                needed[stream.item] = needed.get(stream.item, 0.0) + pieces_per_s
                fetched[stream.item] = fetched.get(stream.item, 0.0) + pieces_per_s * stream.fetch_s
        for item, per_s in needed.items():
            round_s = REFILL_S + fetched[item] / per_s
            lot = plant.materials[item].lot
            kept = [
                stock.capacity // lot * lot
                for place in plant.storages_of(item)
                for stock in plant.stores[place].stocks
                if stock.material == item
            ]
            remedy = Reason("remedy_material", kept=sum(kept))
            yield Limit("material", item, sum(kept) / round_s / per_s, remedy)

    def _vehicle_limits(self) -> Iterator[Limit]:
        """Limits of every set of abilities: the vehicles that have one of them carry all items that need one of them."""
        plant = self.plant
        needed_s: dict[str, float] = {}
        for stream in self.streams:
            ability = plant.ability_of(stream.item)
            needed_s[ability] = needed_s.get(ability, 0.0) + stream.per_s * stream.took_s
        for chosen in _combinations(tuple(needed_s)):
            able = [name for name, kind in self._kinds.items() if set(chosen) & set(kind.abilities)]
            busy = sum(needed_s[ability] for ability in chosen)
            count = sum(self._count[name] for name in able)
            at_work = self._at_work_frac(count)
            given = at_work * sum(self._count[name] * self._working_frac(self._kinds[name]) for name in able)
            name = Reason("that_carry", count=round(at_work * count), abilities=joined("or", chosen))
            more = max(1, round(busy / max(given, 1e-9) * count + 0.5) - count) if given > 0.0 else count
            remedy = Reason("remedy_vehicles", count=more)
            if at_work < 1.0:
                # One more vehicle would be one more of the reserve.
                remedy = counted("add_parking", "add_parkings", plant.spare_places.reserve_size)
            yield Limit("vehicles", name, given / busy, remedy)

    def _charger_limits(self) -> Iterator[Limit]:
        """The fleet's consumption comes through the chargers."""
        plant = self.plant
        fleet = [(self._count[name], kind) for name, kind in self._kinds.items()]
        given_w = (
            len(plant.chargers) * CHARGER_SHARE * sum(n * k.charge_w for n, k in fleet) / len(plant.fleet)
        )
        idle_w = sum(count * kind.idle_w for count, kind in fleet)
        work_w = sum(stream.per_s * stream.energy_wh * 3600.0 for stream in self.streams)
        vehicles = Reason("vehicles_many", count=len(plant.fleet))
        name = Reason("chargers_for", chargers=len(plant.chargers), vehicles=vehicles)
        needed = (idle_w + work_w) / max(given_w / len(plant.chargers), 1e-9)
        remedy = Reason("remedy_more", count=max(1, round(needed + 0.5) - len(plant.chargers)))
        yield Limit("charger", name, max(0.0, given_w - idle_w) / max(work_w, 1e-9), remedy)

    # --- how it is done ---

    def _at_work_frac(self, able: int) -> float:
        """Part of so many vehicles that is not the reserve; its places are taken by all types alike."""
        spare = self.plant.spare_places
        return 1.0 - spare.reserve_size / len(self.plant.fleet) if spare.holds_back_from(able) else 1.0

    def _working_frac(self, kind: VehicleType) -> float:
        """Fraction of its time in which a vehicle does not recharge its consumption."""
        drain_w = (
            kind.idle_w + kind.max_speed_mps * 0.5 * (kind.drive_wh_per_m + kind.loaded_wh_per_m) * 1800.0
        )
        return kind.charge_w / (kind.charge_w + drain_w)

    def _handling_s(self, item: str) -> tuple[float, float]:
        """Mean seconds of loading and of unloading."""
        able = self._able(self.plant.ability_of(item))
        count = sum(self._count[kind.id] for kind in able)
        return (
            sum(self._count[kind.id] * kind.load_s for kind in able) / count,
            sum(self._count[kind.id] * kind.unload_s for kind in able) / count,
        )

    def _able(self, ability: str) -> list[VehicleType]:
        return [kind for kind in self._kinds.values() if ability in kind.abilities]

    def _pieces_per_s(self) -> dict[tuple[str, str], float]:
        """Per machine and item, pieces in or out a second while the machine works all the time."""
        plant = self.plant
        rates: dict[tuple[str, str], float] = {}
        for machine, shares in self.busy.items():
            for product, share in shares.items():
                made = share / plant.cycle_s(machine, product)
                rates[machine, product] = made
                for line in plant.products[product].bill:
                    key = machine, line.material
                    rates[key] = rates.get(key, 0.0) + made * line.quantity
        return rates

    def _streams(self) -> Iterator[Stream]:
        plant = self.plant
        self._starts = _spread((*plant.machines, *plant.delivery_warehouses), MAX_STARTS)
        self._approaches: dict[tuple[str, str], tuple[float, float]] = {}
        for (machine, item), pieces_per_s in self._pieces_per_s().items():
            if pieces_per_s <= 0.0:
                continue
            makes = machine in plant.machines_for(item)
            if item in plant.materials and not makes:
                loads_per_s = pieces_per_s / plant.materials[item].lot
                yield self._stream(item, plant.storages_of(item), (machine,), loads_per_s)
                if refilled := self._refilled(item):
                    yield self._stream(item, plant.supplies_of(item), refilled, loads_per_s)
            else:
                yield self._stream(
                    item,
                    (machine,),
                    # Parts go to a storage, at most; some go directly to machines that need them.
                    plant.storages_of(item) if item in plant.parts else plant.delivery_warehouses,
                    pieces_per_s / plant.products[item].lot * PART_LOADS,
                )

    def _refilled(self, item: str) -> list[str]:
        """The storages of a material that vehicles refill."""
        if item in self.plant.parts:
            return []
        return [each.id for each in self.plant.storages.values() if each.refills(item)]

    def _stream(self, item: str, sources: Sequence[str], destinations: Sequence[str], per_s: float) -> Stream:
        """One stream over the shortest way, averaged over the vehicles that can carry it."""
        plant = self.plant
        able = self._able(plant.ability_of(item))
        took_s = lead_s = fetch_s = energy_wh = dearest_frac = 0.0
        usable_frac = USABLE_FRAC
        count = sum(self._count[kind.id] for kind in able)
        ends = sources[0], destinations[0]
        for kind in able:
            routes = plant.routes(kind.id)
            ends = min(
                ((source, there) for source in sources for there in destinations),
                key=lambda pair: routes.duration_s(plant.node_of(pair[0]), plant.node_of(pair[1])),
            )
            way = routes.way(plant.node_of(ends[0]), plant.node_of(ends[1]))
            approach_s, approach_m = self._approach(kind.id, ends[0])
            one_s = approach_s + kind.load_s + way.duration_s + kind.unload_s + NEGOTIATION_S
            one_wh = approach_m * kind.drive_wh_per_m + way.length_m * kind.loaded_wh_per_m
            share = self._count[kind.id] / count
            took_s += share * one_s
            lead_s += share * one_s
            fetch_s += share * (NEGOTIATION_S + approach_s + kind.load_s)
            energy_wh += share * one_wh
            one_frac = (one_wh + one_s * kind.idle_w / 3600.0) / kind.battery_wh
            can_frac = min(USABLE_FRAC, kind.charging.up_to_frac - plant.charger_queue.base_frac(kind.id))
            if one_frac * usable_frac > dearest_frac * can_frac:
                dearest_frac, usable_frac = one_frac, can_frac
        least_frac = self._least_frac(able, sources, destinations)
        times_s = took_s, lead_s, fetch_s
        return Stream(item, *ends, per_s, *times_s, energy_wh, dearest_frac, usable_frac, least_frac)

    def _least_frac(
        self, able: Iterable[VehicleType], sources: Sequence[str], destinations: Sequence[str]
    ) -> float:
        """See `Stream.least_frac`."""
        least_frac = float("inf")
        for kind in able:
            for source in sources:
                for there in destinations:
                    least_frac = min(least_frac, self._round_frac(kind, source, there))
                    if least_frac <= 1.0:
                        return least_frac
        return least_frac

    def _round_frac(self, kind: VehicleType, source: str, there: str) -> float:
        """Part of a battery for a load from the nearest charger, and for what must be left at its destination."""
        plant, routes = self.plant, self.plant.routes(kind.id)
        begin, end = plant.node_of(source), plant.node_of(there)
        try:
            comes = min(
                (routes.way(plant.node_of(charger), begin) for charger in plant.chargers),
                key=lambda way: way.length_m * kind.drive_wh_per_m + way.duration_s * kind.idle_w / 3600.0,
            )
            loaded, (_, back) = routes.way(begin, end), routes.nearest(end, plant.chargers)
        except NoWay:
            return 0.0  # Another check names it.
        took_s = comes.duration_s + kind.load_s + loaded.duration_s + kind.unload_s
        used_wh = comes.length_m * kind.drive_wh_per_m + loaded.length_m * kind.loaded_wh_per_m
        used_wh += took_s * kind.idle_w / 3600.0
        return used_wh / kind.battery_wh + plant.charger_queue.needed_frac(
            kind.id, back.length_m, back.duration_s
        )

    def _approach(self, kind: str, source: str) -> tuple[float, float]:
        """Mean seconds and metres of the empty way to a source."""
        known = self._approaches.get((kind, source))
        if known is None:
            routes, node = self.plant.routes(kind), self.plant.node_of(source)
            ways = [routes.way(self.plant.node_of(start), node) for start in self._starts]
            known = (
                sum(way.duration_s for way in ways) / len(ways),
                sum(way.length_m for way in ways) / len(ways),
            )
            self._approaches[kind, source] = known
        return known


def _deal_out(plant: Plant) -> dict[str, dict[str, float]]:
    """Per machine and product, the part of its time at load 1, as evenly as the machines' abilities allow."""
    # All products are equally likely in an order, so pieces are as the lots are; and parts as these products need
    # them.
    pieces: defaultdict[str, float] = defaultdict(float)
    for product in plant.ordered:
        _explode(plant, product, plant.products[product].lot * LOTS_PER_ORDER, pieces)
    work = {
        product: pieces[product]
        * sum(plant.cycle_s(machine, product) for machine in plant.machines_for(product))
        / len(plant.machines_for(product))
        for product in plant.products
    }
    scale = len(plant.machines) / sum(work.values())
    busy: dict[str, dict[str, float]] = {machine: {} for machine in plant.machines}
    total = dict.fromkeys(plant.machines, 0.0)
    # Products with few machines are served first; the others get the rest.
    for product in sorted(work, key=lambda each: len(plant.machines_for(each))):
        machines = plant.machines_for(product)
        mean_s = sum(plant.cycle_s(machine, product) for machine in machines) / len(machines)
        part = work[product] * scale / SHARES
        for _ in range(SHARES):
            machine = min(
                machines, key=lambda each: total[each] + part * plant.cycle_s(each, product) / mean_s
            )
            more = part * plant.cycle_s(machine, product) / mean_s
            total[machine] += more
            busy[machine][product] = busy[machine].get(product, 0.0) + more
    return busy


def _explode(plant: Plant, product: str, count: float, pieces: defaultdict[str, float]) -> None:
    """Count the pieces of a product, and of all parts below it."""
    pieces[product] += count
    for line in plant.products[product].bill:
        if line.material in plant.parts:
            _explode(plant, line.material, count * line.quantity, pieces)


def _combinations(abilities: tuple[str, ...]) -> Iterable[tuple[str, ...]]:
    if len(abilities) > MAX_ABILITIES:
        return (*((each,) for each in abilities), abilities)
    return (chosen for count in range(1, len(abilities) + 1) for chosen in combinations(abilities, count))


def _spread(places: Sequence[str], count: int) -> tuple[str, ...]:
    """At most `count` of the places, evenly spread."""
    step = max(1, -(-len(places) // count))
    return tuple(places[::step])
