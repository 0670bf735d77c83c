"""Products over REST: defined while the plant runs, by revision, and ordered at once."""

from __future__ import annotations

from typing import Any

import httpx
import pytest
from answers import problem
from gateway_kit import House, gateway

from dray.gateway.access.principal import Role, Scope
from dray.gateway.factory.catalogue import Catalogue
from dray.gateway.http.provided import provided
from dray.messages import BillLine, MachineCycle, ProductDefinition

pytestmark = pytest.mark.anyio

NEW = {"If-None-Match": "*"}


def body(house: House, **changes: Any) -> dict[str, Any]:
    """A product of the first material, made at the first machine."""
    plant = house.projection.site.plant
    material, machine = next(iter(plant.materials)), next(iter(plant.machines))
    fields = {
        "name": "Bracket",
        "lot": 2,
        "ability": plant.abilities[0],
        "bill": {material: 2},
        "machines": {machine: 12.5},
    }
    return fields | changes


async def define(
    house: House, headers: dict[str, str], id_: str = "bracket", **changes: Any
) -> httpx.Response:
    return await house.client.put(f"/api/products/{id_}", json=body(house, **changes), headers=headers)


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
    assert seen.json() == answer.json() == {**body(house), "id": "bracket", "revision": 1}
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


async def test_another_gateway_finds_what_was_defined(url: str) -> None:
    async with (
        gateway(url) as first,
        gateway(url, bus=first.bus, wall=first.wall, gateway_name="g2") as other,
    ):
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
