"""Judging: why products cannot be made or carried in a plant. Pure; slow for a whole file, so side work."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence

import msgspec

from dray.gateway.http.csv_rows import RowFault, first_by_row, text_of_file
from dray.gateway.http.fault_codes import coded
from dray.gateway.http.problems import FieldError
from dray.gateway.http.request_bodies import RowsFile
from dray.gateway.http.unread import read
from dray.gateway.products.csv_import import read_products
from dray.gateway.products.drafts import Wanted, wanted
from dray.messages import BillLine, MachineCycle, ProductDefinition
from dray.plant import Defined, Plant, file_with_products, products_faults
from dray.plant.model import PlantFile

MACHINE = re.compile(r"^machines\[(\d+)\](.*)$")

DEFINITION_BYTES = 24_000
"""Maximum bytes of a definition as JSON, so that an order of two such products fits a message
(`dray.codec.MAX_BYTES`)."""


class Known(msgspec.Struct, frozen=True):
    """The data by which products are judged."""

    plant: bytes
    """The present plant file."""
    own: bytes
    """The plant file as read at the start, with the machines' own cycle times."""
    revisions: Mapping[str, int]
    """Revisions of all products that can be ordered."""


class ReadFile(msgspec.Struct, frozen=True):
    """A file of products as read."""

    dry_run: bool
    wishes: list[Wanted] = []
    faults: list[RowFault] = []
    """Faults by row; at most `MAX_FIELD_ERRORS`."""
    hints: list[RowFault] = []
    """Oddities that do not prevent taking it."""


def judge(wishes: Sequence[Wanted], known: Known) -> list[list[FieldError]]:
    """The `faults` of products. Slow: run as side work."""
    own, plant = (msgspec.json.decode(each, type=PlantFile) for each in (known.own, known.plant))
    return faults(Plant(own), plant, wishes)


def read_file(body: bytes, known: Known) -> ReadFile:
    """Read a request with a file, and judge its content. Slow: run as side work.

    Args:
        body: a `RowsFile`.
        known: the data to judge by.

    Raises:
        Problem: the body has another shape, or no file.
    """
    request = read(RowsFile, body)
    file = text_of_file(request.csv, request.base64)
    if file.faults:
        return ReadFile(request.dry_run, faults=file.faults)
    products, wrong = read_products(file.text)
    wishes = [wanted(each.id, each.draft, known.revisions.get(each.id)) for each in products]
    for each, found in zip(products, judge(wishes, known), strict=True):
        wrong += map(each.place, found)
    return ReadFile(request.dry_run, wishes, first_by_row(wrong), file.hints)


def faults(own: Plant, file: PlantFile, wishes: Sequence[Wanted]) -> list[list[FieldError]]:
    """Why products cannot be made or carried, defined one after the other or all at once.

    Args:
        own: the plant as its file was read.
        file: the present plant file.
        wishes: the products to define.

    Returns:
        The faults of each by field of the body; empty for a good one.
    """
    if len(wishes) <= 1:
        return [_faults(own, file, wish) for wish in wishes]
    if not any(_odd(own, file, wish) for wish in wishes) and not products_faults(file, _defined(wishes)):
        return [[] for _ in wishes]
    # Judging a whole plant is slow: if most are good, only few need it on their own.
    half = len(wishes) // 2
    first = faults(own, file, wishes[:half])
    good = [wish for wish, wrong in zip(wishes[:half], first, strict=True) if not wrong]
    return first + faults(own, file_with_products(file, _defined(good)), wishes[half:])


def _defined(wishes: Iterable[Wanted]) -> list[Defined]:
    return [(wish.product, wish.machines) for wish in wishes]


def own_s(own: Plant, machine: str, product: str) -> float | None:
    """A machine's own cycle time for a product in seconds; None if it gives none."""
    return own.cycle_s(machine, product) if machine in own.machines_for(product) else None


def definition(wanted: Wanted) -> ProductDefinition:
    """A product's definition for agents."""
    product = wanted.product
    return ProductDefinition(
        lot=product.lot,
        ability=product.ability,
        bill=tuple(BillLine(line.material, line.quantity) for line in product.bill),
        name=product.name,
        revision=1 if wanted.before is None else wanted.before + 1,
        machines=tuple(MachineCycle(*each) for each in wanted.machines.items()),
        documents=wanted.documents,
    )


def _too_large(wanted: Wanted) -> list[FieldError]:
    """The fault of a definition too large for orders and goals, by field; empty for a good one."""
    size = len(msgspec.json.encode(definition(wanted)))
    if size <= DEFINITION_BYTES:
        return []
    field = "documents" if wanted.documents else "machines"
    return [FieldError.of(field, "definition_too_large", size=size, most=DEFINITION_BYTES)]


def _faults(own: Plant, file: PlantFile, wish: Wanted) -> list[FieldError]:
    found = _odd(own, file, wish)
    return found or [
        FieldError(_of_body(field, file), *coded(reason))
        for field, reason in products_faults(file, _defined([wish]))
    ]


def _odd(own: Plant, file: PlantFile, wish: Wanted) -> list[FieldError]:
    """The faults of one product by itself, by field."""
    product, cycles_s = wish.product, wish.machines
    machines = [machine.id for machine in file.machines]
    found = [
        FieldError.of(f"machines.{machine}", "machine_unknown", machine=machine, machines=", ".join(machines))
        for machine in cycles_s
        if machine not in machines
    ]
    for machine, cycle_s in cycles_s.items():
        said_s = own_s(own, machine, product.id)
        if said_s is not None and said_s != cycle_s:
            found.append(
                FieldError.of(
                    f"machines.{machine}", "machine_own_time", machine=machine, seconds=f"{said_s:g}"
                )
            )
    if not cycles_s and not own.machines_for(product.id):
        found.append(FieldError.of("machines", "no_machine"))
    return found or _too_large(wish)


def _of_body(field: str, file: PlantFile) -> str:
    """A plant file's field under its name in the body, where bill and machines are named, not numbered."""
    if of_machine := MACHINE.match(field):
        return f"machines.{file.machines[int(of_machine[1])].id}{of_machine[2]}"
    return field.removeprefix("products[0]").removeprefix(".") or "product"
