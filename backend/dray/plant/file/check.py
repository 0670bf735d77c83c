"""Faults of a plant file whose entries all have the right shape.

A fault is a pair of the field, as ``machines[3].node``, and the reason with its remedy. All faults are found in one
go; an entry that depends on a faulty one is not reported a second time. `dray.plant.file.check_floor` checks
positions and lanes.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from difflib import get_close_matches

from dray.plant.file.check_doors import door_faults
from dray.plant.file.check_floor import floor_faults
from dray.plant.file.check_levels import level_faults, made_into
from dray.plant.file.check_names import name_faults
from dray.plant.file.check_stocks import once, stock_faults, stocks_of, stored_for_machines
from dray.plant.file.check_working_time import working_time_faults
from dray.plant.file.reasons import Reason
from dray.plant.file.unfinished import unassigned_fault
from dray.plant.layout import stop_points
from dray.plant.model import Lane, MachineSpec, Material, PlantFile, Product

Fault = tuple[str, str]
"""Field and reason."""

SPACES = (
    ("nodes",),
    ("materials", "products"),
    ("stations",),
    ("areas",),
    ("vehicle_types",),
    ("doors",),
    ("warehouses", "storages", "chargers", "parkings", "machines", "fleet", "unassigned"),
)
"""Sections that share one space of ids: items are asked for by id alone, and so are places and agents."""

RESERVED = {
    **dict.fromkeys(("strategist", "gate", "historian", "gateway"), Reason("reserved_agent")),
    **dict.fromkeys((f"strategist{number}" for number in range(2, 10)), Reason("reserved_strategist")),
    **dict.fromkeys(("floor", "observer", "authority"), Reason("reserved_certificate")),
}
"""Reserved names, in small letters. A machine or vehicle with such a name would get the messages of another agent, or
would replace its certificate and its log."""

MAX_COMPARED = 5_000
"""Names that a misspelt one is compared with; about 30 ms."""

PLAUSIBLE = {
    "acceleration_mps2": (0.01, 20.0),
    "closes_after_s": (0.0, 3600.0),
    "cycle_s": (0.1, 1e6),
    "length_m": (0.1, 20.0),
    "load_s": (0.01, 1e5),
    "max_speed_mps": (0.05, 50.0),
    "opening_s": (0.1, 600.0),
    "speed_limit_mps": (0.05, 50.0),
    "turn_speed_mps": (0.01, 50.0),
    "unload_s": (0.01, 1e5),
    "width_m": (0.1, 10.0),
}
"""Lowest and highest value: beyond them the unit is wrong, and a simulation would hang."""


LEAST_CHARGE_FRAC = 0.05
"""Smallest difference between two thresholds of charging: for less, the way to a charger is not worth it."""


def faults(file: PlantFile) -> Iterator[Fault]:
    """All contradictions in a plant file; none in a good one. Reasons have codes (`dray.plant.file.reasons`)."""
    yield from _ids(file)
    yield from _references(file)
    yield from _values(file)
    yield from _charging(file)
    yield from _items(file)
    yield from level_faults(file)
    yield from stock_faults(file, (*file.materials, *_parts(file)))
    yield from _machines(file)
    yield from _kinds_of_warehouse(file)
    yield from floor_faults(file)
    yield from door_faults(file)
    yield from working_time_faults(file)
    yield from name_faults(file)
    for index, station in enumerate(file.unassigned):
        yield unassigned_fault(index, station.id, station.node)


def item_faults(file: PlantFile) -> Iterator[Fault]:
    """Contradictions among materials, products, their makers and their carriers, without the floor.

    Reasons have codes (`dray.plant.file.reasons`).
    """
    yield from _ids(file)
    yield from _references(file)
    yield from _values(file)
    yield from _items(file)
    yield from level_faults(file)
    yield from _machines(file)


def _ids(file: PlantFile) -> Iterator[Fault]:
    for sections in SPACES:
        owners: dict[str, str] = {}
        for section in sections:
            for index, spec in enumerate(getattr(file, section)):
                field = f"{section}[{index}]"
                if spec.id in owners:
                    yield f"{field}.id", Reason("plant_id_taken", name=spec.id, owner=owners[spec.id])
                owners.setdefault(spec.id, field)
                if "fleet" in sections and (taken := RESERVED.get(spec.id.lower())):
                    yield f"{field}.id", Reason("id_reserved", name=spec.id, taken=taken)


def _references(file: PlantFile) -> Iterator[Fault]:
    """Names without a definition."""
    known = {
        section: {spec.id for spec in getattr(file, section)} for sections in SPACES for section in sections
    }
    for section in ("warehouses", "storages", "chargers", "parkings", "machines", "unassigned"):
        for index, spec in enumerate(getattr(file, section)):
            yield from _known(spec.node, f"{section}[{index}].node", known, "nodes")
    stands = known | {"nodes": known["nodes"] | stop_points(file)}
    for index, vehicle in enumerate(file.fleet):
        yield from _known(vehicle.node, f"fleet[{index}].node", stands, "nodes")
    for index, lane in enumerate(file.lanes):
        yield from _known(lane.start, f"lanes[{index}].start", known, "nodes")
        yield from _known(lane.end, f"lanes[{index}].end", known, "nodes")
        yield from _lane_types(lane, f"lanes[{index}].types", known)
    whole = {product.id for product in file.products if not product.buffer}
    used = known | {"materials": known["materials"] | known["products"]}
    for index, product in enumerate(file.products):
        for at, line in enumerate(product.bill):
            yield from _used(line.material, f"products[{index}].bill[{at}].material", used, whole)
    for where, kept in stocks_of(file):
        yield from _used(kept.material, f"{where}.material", used, whole)
    for index, machine in enumerate(file.machines):
        yield from _known(machine.station, f"machines[{index}].station", known, "stations")
        for at, making in enumerate(machine.makes):
            yield from _known(making.product, f"machines[{index}].makes[{at}].product", known, "products")
    for index, vehicle in enumerate(file.fleet):
        yield from _known(vehicle.type, f"fleet[{index}].type", known, "vehicle_types")


def _lane_types(lane: Lane, where: str, known: Mapping[str, Collection[str]]) -> Iterator[Fault]:
    """Types of vehicles that a lane names: each once."""
    for at, each in enumerate(lane.types):
        field = f"{where}[{at}].type"
        yield from _known(each.type, field, known, "vehicle_types")
        if each.type in [other.type for other in lane.types[:at]]:
            yield field, Reason("type_twice", type=each.type)


def _known(name: str, field: str, known: Mapping[str, Collection[str]], section: str) -> Iterator[Fault]:
    if name not in known[section]:
        # Sorted, so that the same file gives the same advice in every process.
        names = sorted(known[section]) if len(known[section]) <= MAX_COMPARED else []
        alike = get_close_matches(name, names, n=1)
        advice = Reason("did_you_mean", name=alike[0]) if alike else Reason("add_or_other")
        yield field, Reason("plant_unknown", name=name, section=section, advice=advice)


def _used(
    name: str, field: str, known: Mapping[str, Collection[str]], whole: Collection[str]
) -> Iterator[Fault]:
    """A material or a part."""
    if name in whole:
        yield field, Reason("plant_no_buffer", name=name)
    else:
        yield from _known(name, field, known, "materials")


def _values(file: PlantFile) -> Iterator[Fault]:
    """Values that only a mistaken unit explains."""
    entries: list[tuple[str, object]] = [
        *((f"lanes[{index}]", lane) for index, lane in enumerate(file.lanes)),
        *((f"vehicle_types[{index}]", kind) for index, kind in enumerate(file.vehicle_types)),
        *((f"doors[{index}]", door) for index, door in enumerate(file.doors)),
        *(
            (f"machines[{index}].makes[{at}]", making)
            for index, machine in enumerate(file.machines)
            for at, making in enumerate(machine.makes)
        ),
    ]
    for where, entry in entries:
        for field, (low, high) in PLAUSIBLE.items():
            value = getattr(entry, field, low)
            if not low <= value <= high:
                reason = Reason("plant_implausible", value=f"{value:g}", least=f"{low:g}", most=f"{high:g}")
                yield f"{where}.{field}", reason


def _charging(file: PlantFile) -> Iterator[Fault]:
    """Thresholds that would send a vehicle to and from its charger for nothing."""
    for index, kind in enumerate(file.vehicle_types):
        where, rules = f"vehicle_types[{index}].charging", kind.charging
        for low, high in (("must_below_frac", "below_frac"), ("below_frac", "up_to_frac")):
            low_frac, high_frac = getattr(rules, low), getattr(rules, high)
            if high_frac - low_frac < LEAST_CHARGE_FRAC - 1e-9:
                reason = Reason("threshold", high=high_frac, least=LEAST_CHARGE_FRAC, field=low, low=low_frac)
                yield f"{where}.{high}", reason
        for at, hours in enumerate(rules.quiet_hours):
            if hours.start_h == hours.end_h:
                reason = Reason("quiet_hours", hour=hours.start_h)
                yield f"{where}.quiet_hours[{at}].end_h", reason


def _items(file: PlantFile) -> Iterator[Fault]:
    """Faults of materials and products: quantities, carriers and makers."""
    kinds = {kind.id: kind for kind in file.vehicle_types}
    types = {vehicle.type for vehicle in file.fleet}
    abilities = {ability for name in types & kinds.keys() for ability in kinds[name].abilities}
    stored = stored_for_machines(file)
    made = {making.product for machine in file.machines for making in machine.makes}
    materials = {material.id: material for material in (*file.materials, *_parts(file))}
    # An unknown item may be a misspelt one, which is reported already.
    all_types = types <= kinds.keys()
    all_stored = stored <= materials.keys()
    all_made = made <= {product.id for product in file.products}
    items: list[tuple[str, Material | Product]] = [
        *((f"materials[{index}]", material) for index, material in enumerate(file.materials)),
        *((f"products[{index}]", product) for index, product in enumerate(file.products)),
    ]
    for where, item in items:
        if all_types and item.ability not in abilities:
            needed = made_into(file, item.id)
            yield (
                f"{where}.ability",
                Reason("plant_ability", ability=item.ability, item=item.id, needed=needed),
            )
    used = [(where, materials[item.id]) for where, item in items if item.id in materials]
    for where, material in used:
        if material.lot > material.buffer:
            yield f"{where}.lot", Reason("plant_lot", lot=material.lot, buffer=material.buffer)
        if all_stored and material.id not in stored:
            yield where, Reason("plant_not_stored", item=material.id, needed=made_into(file, material.id))
    for index, product in enumerate(file.products):
        where = f"products[{index}]"
        if all_made and product.id not in made:
            yield where, Reason("plant_not_made", item=product.id, needed=made_into(file, product.id))
        yield from _bill(product, where, materials)


def _parts(file: PlantFile) -> tuple[Material, ...]:
    parts = (product for product in file.products if product.buffer)
    return tuple(Material(part.id, part.name, part.lot, part.buffer, part.ability) for part in parts)


def _bill(product: Product, where: str, materials: Mapping[str, Material]) -> Iterator[Fault]:
    yield from once((line.material for line in product.bill), f"{where}.bill", "material")
    for at, line in enumerate(product.bill):
        material = materials.get(line.material)
        if material is None or material.lot > material.buffer:
            continue
        if line.quantity > material.buffer:
            reason = Reason("plant_bill", count=line.quantity, buffer=material.buffer, item=material.id)
            yield f"{where}.bill[{at}].quantity", reason
        elif line.quantity + material.lot > material.buffer:
            # Otherwise a machine could hold too little for a cycle and too much for the next container.
            reason = Reason(
                "plant_bill_and_lot", count=line.quantity, lot=material.lot, buffer=material.buffer
            )
            yield f"{where}.bill[{at}].quantity", reason


def _machines(file: PlantFile) -> Iterator[Fault]:
    lots = {product.id: product.lot for product in file.products}
    for index, machine in enumerate(file.machines):
        where = f"machines[{index}]"
        yield from once((making.product for making in machine.makes), f"{where}.makes", "product")
        yield from _goods(machine, where, lots)


def _goods(machine: MachineSpec, where: str, lots: Mapping[str, int]) -> Iterator[Fault]:
    """A product whose lot never fills would never be fetched."""
    largest = max(machine.makes, key=lambda making: lots.get(making.product, 0)).product
    lot = lots.get(largest, 0)
    if machine.goods_capacity < lot:
        reason = Reason("plant_goods", count=machine.goods_capacity, lot=lot, item=largest)
        yield f"{where}.goods_capacity", reason


def _kinds_of_warehouse(file: PlantFile) -> Iterator[Fault]:
    kinds = {warehouse.kind for warehouse in file.warehouses}
    for kind in ("source", "delivery"):
        if kind not in kinds:
            yield "warehouses", Reason(f"no_{kind}")
