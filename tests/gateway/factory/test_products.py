"""Products over REST: defined while the plant runs, by revision, and ordered at once."""

from __future__ import annotations

import asyncio
import base64
from typing import Any

import httpx
import msgspec
import pytest
from answers import problem
from gateway_kit import House, gateway
from msgspec.structs import replace
from products_kit import NEW, body, define

from dray.gateway.access.principal import Role, Scope
from dray.gateway.factory import catalogue
from dray.gateway.factory.catalogue import Catalogue
from dray.gateway.http.provided import provided
from dray.messages import BillLine, Document, MachineCycle, ProductDefinition
from dray.plant import load_plant

pytestmark = pytest.mark.anyio


async def test_a_new_product_can_be_ordered_at_once_and_the_order_brings_its_definition(house: House) -> None:
    given = house.bus.strategist()
    answer = await define(house, NEW)
    assert answer.status_code == 201, answer.text
    assert answer.headers["ETag"] == '"1"'
    await house.place(items=[{"product": "bracket", "quantity": 3}])
    [order] = given
    wanted = body(house)
    [(material, pieces)] = wanted["bill"].items()
    [(machine, cycle_s)] = wanted["machines"].items()
    assert order.items[0].definition == ProductDefinition(
        lot=2,
        ability=wanted["ability"],
        bill=(BillLine(material, pieces),),
        name="Bracket",
        revision=1,
        machines=(MachineCycle(machine, cycle_s),),
    )


async def test_it_is_listed_and_read_with_its_revision(house: House) -> None:
    answer = await define(house, NEW)
    path = "/api/products/bracket"
    seen = await house.client.get(path)
    assert (
        seen.json()
        == answer.json()
        == {
            **body(house),
            "id": "bracket",
            "documents": [],
            "revision": 1,
        }
    )
    assert (await house.client.get(path, headers={"If-None-Match": seen.headers["ETag"]})).status_code == 304
    listed = (await house.get("/api/products"))["items"]
    assert "bracket" in {each["id"] for each in listed}
    problem(await house.client.get("/api/products/nothing"), 404, "unknown-product")


async def test_of_two_who_change_one_product_the_second_is_told(house: House) -> None:
    await define(house, NEW)
    problem(await define(house, {}), 428, "no-version")
    problem(await define(house, NEW), 412, "exists")
    changed = await define(house, {"If-Match": '"1"'}, lot=3)
    assert (changed.status_code, changed.json()["revision"], changed.headers["ETag"]) == (200, 2, '"2"')
    problem(await define(house, {"If-Match": '"1"'}, lot=4), 412, "changed-since")
    problem(await define(house, {"If-Match": '"1"'}, id_="other"), 412, "changed-since")
    assert (await house.get("/api/products/bracket"))["lot"] == 3


async def test_a_product_of_the_plant_file_gets_another_revision(house: House) -> None:
    given = house.bus.strategist()
    [first, *_] = (await house.get("/api/products"))["items"]
    assert first["revision"] == 1
    fields = {key: value for key, value in first.items() if key not in {"id", "revision"}}
    answer = await house.client.put(
        f"/api/products/{first['id']}", json=fields | {"name": "Renamed"}, headers={"If-Match": '"1"'}
    )
    assert answer.json() == first | {"name": "Renamed", "revision": 2}
    await house.place(items=[{"product": first["id"], "quantity": 1}])
    assert [item.definition.revision for item in given[-1].items if item.definition] == [2]


@pytest.mark.parametrize(
    ("changes", "field", "why"),
    [
        ({"bill": {"gold": 1}}, "bill[0].material", "there is no gold in `materials`"),
        ({"ability": "crane"}, "ability", "no vehicle of the fleet can carry crane"),
        ({"machines": {}}, "machines", "no machine makes it"),
        ({"machines": {"M99": 1.0}}, "machines.M99", "there is no machine M99"),
        ({"lot": 100_000}, "goods_capacity", "less than the lot of 100000"),
    ],
)
async def test_what_cannot_be_made_or_carried_is_refused(
    house: House, changes: dict[str, Any], field: str, why: str
) -> None:
    answer = problem(await define(house, NEW, **changes), 422, "unusable-fields")
    [error] = [each for each in answer["errors"] if why in each["reason"]]
    assert field in error["field"]
    assert "bracket" not in {each["id"] for each in (await house.get("/api/products"))["items"]}


async def test_ids_that_name_something_else_are_refused(house: House) -> None:
    material = next(iter(house.projection.site.plant.materials))
    problem(await define(house, NEW, id_=material), 422, "unusable-fields")


async def test_a_machine_that_states_its_own_time_is_not_contradicted(house: House) -> None:
    product = (await house.get("/api/products"))["items"][0]
    machine = next(iter(product["machines"]))
    answer = await define(house, {"If-Match": '"1"'}, id_=product["id"], machines={machine: 1234.5})
    assert f"{machine} says itself" in problem(answer, 422, "unusable-fields")["detail"]


async def test_the_next_gateway_knows_what_was_defined(house: House, url: str) -> None:
    await define(house, NEW)
    await define(house, {"If-Match": '"1"'}, name="Bracket 2")
    async with gateway(url) as next_one:
        seen = await next_one.get("/api/products/bracket")
        assert (seen["name"], seen["revision"]) == ("Bracket 2", 2)


async def test_another_gateway_finds_what_was_defined(two_houses: tuple[House, House]) -> None:
    first, other = two_houses
    await define(first, NEW)
    async with other.store.read() as work:
        await provided(other.app, Catalogue).look(work)
    assert (await other.get("/api/products/bracket"))["revision"] == 1


async def test_only_who_may_change_the_plant_defines_products_and_it_is_written_down(
    house: House, visitor: httpx.AsyncClient
) -> None:
    _, orders = await house.key(Scope.ORDERS_WRITE)
    refused = await visitor.put("/api/products/bracket", json=body(house), headers=NEW | orders)
    problem(refused, 403, "not-allowed")
    manager = await house.log_in("maria", Role.MANAGER)
    answer = await manager.put("/api/products/bracket", json=body(house), headers=NEW)
    assert answer.status_code == 201, answer.text
    lines = (await house.get("/api/audit"))["items"]
    [line] = [each for each in lines if each["action"] == "product.define" and each["result"] == "done"]
    assert (line["who"], line["target"], line["detail"]["revision"]) == ("maria", "bracket", 1)


PDF = {
    "name": "Instruction",
    "address": "https://plm.example/bracket.pdf",
    "media_type": "application/pdf",
    "sha256": "ab" * 32,
}


async def test_an_order_brings_the_documents_of_its_product(house: House) -> None:
    given = house.bus.strategist()
    answer = await define(house, NEW, documents=[PDF])
    assert (answer.status_code, answer.json()["documents"]) == (201, [PDF])
    await house.place(items=[{"product": "bracket", "quantity": 3}])
    assert given[0].items[0].definition.documents == (Document(**PDF),)


@pytest.mark.parametrize(
    ("documents", "field"),
    [
        ([PDF | {"address": "file:///etc/passwd"}], "documents[0].address"),
        ([PDF | {"address": "javascript:alert(1)"}], "documents[0].address"),
        ([PDF | {"sha256": "AB" * 32}], "documents[0].sha256"),
        ([PDF | {"media_type": "pdf"}], "documents[0].media_type"),
        ([PDF, PDF], "documents"),
        ([PDF | {"name": f"{number}"} for number in range(9)], "documents"),
    ],
)
async def test_a_document_that_nobody_could_use_is_refused_by_field(
    house: House, documents: list[dict[str, str]], field: str
) -> None:
    refused = problem(await define(house, NEW, documents=documents), 422, "unusable-fields")
    assert [error["field"] for error in refused["errors"]] == [field]


async def import_csv(house: House, text: str, *, dry_run: bool = False) -> httpx.Response:
    return await house.client.post("/api/products/import", json={"csv": text, "dry_run": dry_run})


def table(house: House, *rows: str) -> str:
    """Rows in which MAT and MACH stand for something of the plant."""
    plant = house.projection.site.plant
    head = "product,name,lot,ability,material,pieces,machine,cycle_s,document,address,media_type,sha256"
    text = "\n".join((head, *rows))
    (first, second, *_), machine = plant.materials, next(iter(plant.machines))
    return (
        text.replace("MAT1", first)
        .replace("MAT2", second)
        .replace("MACH", machine)
        .replace("ABLE", plant.abilities[0])
    )


GOOD = (
    f"B1,Bracket,2,ABLE,MAT1,2,MACH,12.5,Instruction,{PDF['address']},{PDF['media_type']},{PDF['sha256']}",
    "B1,,,,MAT2,1,,,,,,",
    "B2,Plate,4,ABLE,MAT2,3,MACH,8,,,,",
)


async def test_a_file_of_products_is_defined_whole_and_again_changes_nothing(house: House) -> None:
    dry = (await import_csv(house, table(house, *GOOD), dry_run=True)).json()
    assert [(each["id"], each["becomes"]) for each in dry["products"]] == [("B1", "new"), ("B2", "new")]
    assert (await house.client.get("/api/products/B1")).status_code == 404
    taken = (await import_csv(house, table(house, *GOOD))).json()
    assert (taken["faults"], [each["revision"] for each in taken["products"]]) == ([], [1, 1])
    first = (await house.client.get("/api/products/B1")).json()
    assert (len(first["bill"]), first["documents"]) == (2, [PDF])
    again = (await import_csv(house, table(house, *GOOD))).json()
    assert {each["becomes"] for each in again["products"]} == {"unchanged"}
    changed = (await import_csv(house, table(house, GOOD[0], "B2,Plate,5,ABLE,MAT2,3,MACH,8,,,,"))).json()
    told = [(each["becomes"], each["revision"]) for each in changed["products"]]
    assert told == [("changed", 2), ("changed", 2)]
    line, *_ = await house.audit(action="product.import")
    assert msgspec.json.decode(line.detail) == {"products": 2, "changed": 2, "dry_run": False}


@pytest.mark.parametrize(
    ("row", "place"),
    [
        ("B2,Plate,4,ABLE,gold,3,MACH,8,,,,", "row 4, material"),
        ("B2,Plate,4,ABLE,MAT2,3,M99,8,,,,", "row 4, machine"),
        ("B2,Plate,4,ABLE,MAT2,3,MACH,soon,,,,", "row 4, cycle_s"),
        ("B2,Plate,none,ABLE,MAT2,3,MACH,8,,,,", "row 4, lot"),
        ("B2,Plate,4,ABLE,MAT2,3,MACH,8,CAD,https://plm.example/x,text/plain,12", "row 4, sha256"),
        ("9,Plate,4,ABLE,MAT2,3,MACH,8,,,,", "row 4, product"),
        ("B2,Plate,4,ABLE,MAT2,3,,,,,,", "row 4, machine"),
    ],
)
async def test_one_fault_refuses_the_whole_file_and_names_its_row(house: House, row: str, place: str) -> None:
    refused = problem(await import_csv(house, table(house, *GOOD[:2], row)), 422, "unusable-fields")
    assert place in [error["field"] for error in refused["errors"]]
    assert (await house.client.get("/api/products/B1")).status_code == 404


async def test_a_product_that_stands_in_two_places_of_a_file_is_refused(house: House) -> None:
    text = table(house, *GOOD, "B1,Bracket,2,ABLE,MAT1,2,MACH,12.5,,,,")
    refused = problem(await import_csv(house, text), 422, "unusable-fields")
    assert [error["field"] for error in refused["errors"]] == ["row 5, product"]


WITHOUT_SHAFT = {"gear": 2, "bearing": 2}


async def put_part(house: House, part: str, revision: int, **bill: int) -> httpx.Response:
    """Another revision of a part of the plant `levels`."""
    fields = await house.get(f"/api/products/{part}")
    kept = {name: fields[name] for name in ("name", "lot", "ability")}
    headers = {"If-Match": f'"{revision}"'}
    return await house.client.put(f"/api/products/{part}", json=kept | {"bill": bill}, headers=headers)


async def test_of_two_definitions_at_once_that_make_a_circle_one_is_refused_with_the_chain(url: str) -> None:
    """Each is good as long as the other one is not there; also at two gateways."""
    levels = load_plant("levels").file
    async with (
        gateway(url, plant=levels) as house,
        gateway(url, plant=levels, bus=house.bus, wall=house.wall, gateway_name="g2") as other,
    ):
        assert (await put_part(house, "gear-set", 1, **WITHOUT_SHAFT)).status_code == 200
        answers = await asyncio.gather(
            put_part(house, "gear-set", 2, shaft=1, **WITHOUT_SHAFT),
            put_part(other, "shaft", 1, **{"gear-set": 1}),
        )
        assert sorted(answer.status_code for answer in answers) == [200, 422]
        [refused] = [answer for answer in answers if answer.status_code == 422]
        assert any("is made of itself" in each["reason"] for each in refused.json()["errors"])
        one, two = [(await house.get(f"/api/products/{part}"))["revision"] for part in ("gear-set", "shaft")]
        assert one + two == 4


async def test_a_circle_within_one_file_is_refused_with_its_row(url: str) -> None:
    async with gateway(url, plant=load_plant("levels").file) as house:
        text = "\n".join(
            (
                "product,name,lot,ability,material,pieces",
                "gear-set,Gear set,6,tote,gear,2",
                "shaft,Shaft,12,tote,gear-set,1",
                "gear,Gear,16,tote,shaft,1",
            )
        )
        refused = problem(await import_csv(house, text), 422, "unusable-fields")
        [circle] = [each for each in refused["errors"] if "is made of itself" in each["reason"]]
        assert circle["field"] == "row 4, material"
        assert (await house.get("/api/products/shaft"))["revision"] == 1


@pytest.mark.parametrize(
    ("row", "code"),
    [
        ("B3,Bracket,2,ABLE,gold,2,MACH,12.5,,,,", "plant_unknown"),
        ("B3,Bracket,2,ABLE,MAT1,100000,MACH,12.5,,,,", "plant_bill"),
        ("B3,Bracket,2,anything,MAT1,2,MACH,12.5,,,,", "plant_ability"),
        ("B3,Bracket,9999,ABLE,MAT1,2,MACH,12.5,,,,", "plant_goods"),
    ],
)
async def test_what_does_not_fit_into_the_plant_has_a_code_too(house: House, row: str, code: str) -> None:
    dry = (await import_csv(house, table(house, row), dry_run=True)).json()
    assert code in [fault["code"] for fault in dry["faults"]]
    # All that stands in the English is handed on, for who tells it in another language.
    fault = next(fault for fault in dry["faults"] if fault["code"] == code)
    assert all(value in fault["reason"] for value in fault["values"].values())


async def test_a_file_of_products_is_read_in_its_own_encoding_and_says_so(house: House) -> None:
    text = table(house, "P9,Prüfstück,4,,MAT1,2,MACH,12,,,,").replace(",", ";")
    body = {"base64": base64.b64encode(text.encode("windows-1252")).decode(), "dry_run": True}
    answer = (await house.client.post("/api/products/import", json=body)).json()
    assert [product["name"] for product in answer["products"]] == ["Prüfstück"]
    assert [hint["code"] for hint in answer["hints"]] == ["csv_read_as"]


async def test_no_pattern_is_told_of_a_cell_that_cannot_be_used(house: House) -> None:
    text = table(house, "P9,Gear,4,9 x,MAT1,2,MACH,12,plan,ftp:x,pdf,AB")
    faults = (await import_csv(house, text, dry_run=True)).json()["faults"]
    assert sorted(fault["column"] for fault in faults) == ["ability", "address", "media_type", "sha256"]
    for fault in faults:
        assert fault["code"] == "pattern"
        assert not set("^$\\[") & set(fault["reason"])


async def test_one_caller_defines_half_of_what_all_may_and_all_no_more_than_that(
    house: House, visitor: httpx.AsyncClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(catalogue, "PRODUCTS_MAX", 4)
    floor = Scope.FLOOR_WRITE
    callers = [(await house.key(floor, name=who))[1] for who in ("ERP", "MES", "PLM")]

    async def put(caller: dict[str, str], id_: str, **headers: str) -> httpx.Response:
        return await visitor.put(f"/api/products/{id_}", json=body(house), headers=caller | headers)

    erp, mes, plm = callers
    assert [(await put(erp, f"E{each}", **NEW)).status_code for each in range(2)] == [201, 201]
    refused = await put(erp, "E2", **NEW)
    [error] = problem(refused, 429, "share-used")["errors"]
    assert (error["field"], error["code"], error["values"]) == ("caller", "share_used", {"most": "2"})
    assert "Retry-After" not in refused.headers
    # What there is may be changed by whoever has no room for more, and all of a file is refused.
    assert (await put(erp, "E1", **{"If-Match": '"1"'})).status_code == 200
    file = {"csv": table(house, *GOOD)}
    problem(await visitor.post("/api/products/import", json=file, headers=erp), 429, "share-used")
    taken = await visitor.post("/api/products/import", json=file, headers=mes)
    assert taken.status_code == 200, taken.text
    problem(await put(plm, "P1", **NEW), 409, "too-many-products")
    known = {each["id"] for each in (await house.get("/api/products"))["items"]}
    assert {"E0", "E1", "B1", "B2"} <= known
    assert not {"E2", "P1"} & known


async def test_of_what_was_defined_the_next_gateway_leaves_out_only_what_does_not_fit(url: str) -> None:
    """The plant has lost a material meanwhile."""
    levels = load_plant("levels").file
    async with gateway(url, plant=levels) as house:
        plant = house.projection.site.plant
        machine = next(iter(plant.machines))
        for id_, material in (("A1", "bar"), ("A2", "blank"), ("A3", "bar"), ("A4", "bar")):
            answer = await define(house, NEW, id_, bill={material: 1}, machines={machine: 5.0})
            assert answer.status_code == 201, answer.text
        async with house.store.write() as work:
            [row] = [each for each in await work.products.defined() if each.id == "A2"]
            gone = row.definition.replace('"blank"', '"gone"')
            assert gone != row.definition
            await work.products.define(replace(row, definition=gone, revision=2))
    async with gateway(url, plant=levels) as next_one:
        known = {each["id"] for each in (await next_one.get("/api/products"))["items"]}
        assert {"A1", "A2", "A3", "A4"} & known == {"A1", "A3", "A4"}


@pytest.mark.anyio
@pytest.mark.parametrize(
    ("cells", "column", "code"),
    [
        ("4;steel;;M1;12", "pieces", "missing"),
        ("4;steel;2,5;M1;12", "pieces", "whole_number"),
        ("4;steel;-2;M1;12", "pieces", "at_least"),
        ("4;steel;2;M1;", "cycle_s", "missing"),
        ("4;steel;2;M1;1.234,5", "cycle_s", "number"),
        ("4;steel;2;M1;nan", "cycle_s", "number"),
        ("4;steel;2;M1;-3", "cycle_s", "at_least"),
        (";steel;2;M1;12", "lot", "missing"),
        ("4,0;steel;2;M1;12", "lot", "whole_number"),
    ],
)
async def test_a_number_of_a_part_is_refused_in_its_own_column(
    house: House, cells: str, column: str, code: str
) -> None:
    text = f"product;name;lot;material;pieces;machine;cycle_s\nP99;Bracket;{cells}\n"
    answer = (await house.client.post("/api/products/import", json={"csv": text, "dry_run": True})).json()
    assert [(fault["row"], fault["column"], fault["code"]) for fault in answer["faults"]] == [
        (2, column, code)
    ]
