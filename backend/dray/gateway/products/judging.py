"""Judging: why products cannot be made or carried in a plant. Pure; of a whole file it takes its time, and is side work."""

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
"""Of a definition as JSON: an order of two such products is still a message (`dray.codec.MAX_BYTES`)."""


class Known(msgspec.Struct, frozen=True):
    """What products are judged by."""

    plant: bytes
    """The file of the plant as it is now."""
    own: bytes
    """Its file as it was read: the machines' own word on their cycles."""
    revisions: Mapping[str, int]
    """Of all products that can be ordered."""


class ReadFile(msgspec.Struct, frozen=True):
    """A file of products as it came."""

    dry_run: bool
    wishes: list[Wanted] = []
    faults: list[RowFault] = []
    """By row; the first `MAX_FIELD_ERRORS`."""
    hints: list[RowFault] = []
    """What is odd in it and taken all the same."""


def judge(wishes: Sequence[Wanted], known: Known) -> list[list[FieldError]]:
    """`faults` by what is known. Takes its time: side work."""
    own, plant = (msgspec.json.decode(each, type=PlantFile) for each in (known.own, known.plant))
    return faults(Plant(own), plant, wishes)


def read_file(body: bytes, known: Known) -> ReadFile:
    """Read a body that holds a file, and judge what is in it. Takes its time: side work.

    Args:
        body: a `RowsFile`.
        known: what it is judged by.

    Raises:
        Problem: the body is not of this shape, or there is no file in it.
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
    """Why products cannot be made or carried when they are defined one after the other, or all of them at once.

    Args:
        own: the plant as its file was read.
        file: as it is now.
        wishes: what is to be defined.

    Returns:
        Of each, what is wrong by field of the body; nothing for a good one.
    """
    if len(wishes) <= 1:
        return [_faults(own, file, wish) for wish in wishes]
    if not any(_odd(own, file, wish) for wish in wishes) and not products_faults(file, _defined(wishes)):
        return [[] for _ in wishes]
    # To judge a whole plant takes its time: where most are good, it is done for few of them alone.
    half = len(wishes) // 2
    first = faults(own, file, wishes[:half])
    good = [wish for wish, wrong in zip(wishes[:half], first, strict=True) if not wrong]
    return first + faults(own, file_with_products(file, _defined(good)), wishes[half:])


def _defined(wishes: Iterable[Wanted]) -> list[Defined]:
    return [(wish.product, wish.machines) for wish in wishes]


def own_s(own: Plant, machine: str, product: str) -> float | None:
    """What a machine says itself of its time for a product, in seconds; None where it says nothing."""
    return own.cycle_s(machine, product) if machine in own.machines_for(product) else None


def definition(wanted: Wanted) -> ProductDefinition:
    """What agents are told of a product."""
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
    """Whether a definition is more than orders and goals can carry, by field; nothing for a good one."""
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
    """What is wrong with one by itself, by field."""
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
    """A field of the plant, as the body of a request calls it: its bill and its machines are named there, not numbered."""
    if of_machine := MACHINE.match(field):
        return f"machines.{file.machines[int(of_machine[1])].id}{of_machine[2]}"
    return field.removeprefix("products[0]").removeprefix(".") or "product"
