"""Products that people have defined are removed: none that something needs, for good, and in every gateway."""

from __future__ import annotations

import asyncio
from typing import Any

import httpx
import msgspec
import pytest
from answers import problem
from gateway_kit import PRODUCT, House, gateway
from heartbeats import machine_heartbeat
from msgspec.structs import replace
from products_kit import NEW, body, define
from recurring_kit import added

from dray.errors import UnavailableError
from dray.gateway.access.principal import Scope
from dray.gateway.factory import catalogue
from dray.gateway.factory.catalogue import Catalogue
from dray.gateway.http.provided import provided
from dray.gateway.tracking.facts import facts_of
from dray.messages import GoalBrief
from dray.plant import BillLine, load_plant
from dray.store.orders import products
from dray.store.orders.products import DefinedProduct, Products

pytestmark = pytest.mark.anyio

PATH = "/api/products/bracket"


@pytest.fixture(autouse=True)
def asked_by_the_test_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Recurring work happens when a test says so: never here."""
    monkeypatch.setattr("dray.gateway.schedules.scheduler.Scheduler.run", lambda _: asyncio.Event().wait())


async def defined(house: House, *ids: str) -> None:
    for id_ in ids or ("bracket",):
        answer = await define(house, NEW, id_)
        assert answer.status_code == 201, answer.text


async def remove(house: House, id_: str = "bracket", **headers: str) -> httpx.Response:
    return await house.client.delete(f"/api/products/{id_}", headers=headers)


async def removed(house: House, *ids: str) -> dict[str, dict[str, Any]]:
    """What became of several, by id."""
    answer = await house.client.post("/api/products/remove", json={"products": list(ids)})
    assert answer.status_code == 200, answer.text
    return {each.pop("id"): each for each in answer.json()["products"]}


async def listed(house: House) -> set[str]:
    return {each["id"] for each in (await house.get("/api/products"))["items"]}


async def look(house: House) -> None:
    """What the gateway does every two seconds."""
    async with house.store.read() as work:
        await provided(house.app, Catalogue).look(work)


async def test_a_removed_product_is_not_there_any_more_and_it_is_written_down(house: House) -> None:
    await defined(house)
    assert (await remove(house)).status_code == 204
    problem(await house.client.get(PATH), 404, "unknown-product")
    assert "bracket" not in await listed(house)
    assert "bracket" not in {each["id"] for each in (await house.get("/api/plant"))["products"]}
    refused = await house.client.post(
        "/api/orders", json={"customer": "A", "items": [{"product": "bracket", "quantity": 1}]}
    )
    problem(refused, 422, "unusable-fields")
    line, *_ = await house.audit(action="product.remove")
    assert (line.target, line.result) == ("bracket", "done")
    problem(await remove(house), 404, "unknown-product")
    problem(await remove(house, "nothing"), 404, "unknown-product")


async def test_panels_are_told_of_another_plant_when_a_product_is_defined_or_removed(house: House) -> None:
    async def told_s() -> float:
        house.wall.now_s += 1.0
        changed_s: float = (await house.get("/api/kpis"))["plant_at_s"]
        # The plant itself says which one it is.
        assert float((await house.client.get("/api/plant")).headers["Plant-At-S"]) == changed_s
        return changed_s

    before_s = await told_s()
    assert await told_s() == before_s
    await defined(house)
    defined_s = await told_s()
    assert defined_s > before_s
    await remove(house)
    removed_s = await told_s()
    assert removed_s > defined_s
    assert await told_s() == removed_s


async def test_it_stays_away_when_the_gateway_starts_again(house: House, url: str) -> None:
    await defined(house)
    await remove(house)
    async with gateway(url) as next_one:
        assert "bracket" not in await listed(next_one)


async def test_another_gateway_forgets_it_too_and_so_does_one_that_was_away(
    two_houses: tuple[House, House],
) -> None:
    first, other = two_houses
    await defined(first)
    await look(other)
    assert "bracket" in await listed(other)
    await remove(first)
    await look(other)
    assert "bracket" not in await listed(other)
    # While it is away, it is defined once more and removed, and another one is defined.
    await defined(first)
    await remove(first)
    await defined(first, "plate")
    await look(other)
    assert {"bracket", "plate"} & await listed(other) == {"plate"}


async def test_one_defined_anew_has_the_next_revision_also_where_the_removal_was_not_heard(
    two_houses: tuple[House, House],
) -> None:
    first, other = two_houses
    await defined(first)
    await look(other)
    await remove(first)
    again = await define(first, NEW, name="Bracket of steel")
    assert (again.status_code, again.json()["revision"], again.headers["ETag"]) == (201, 3, '"3"')
    await look(other)
    assert (await other.get(PATH))["name"] == "Bracket of steel"
    # Whoever has read the first one does not change the new one by mistake.
    problem(await define(first, {"If-Match": '"1"'}), 412, "changed-since")
    assert (await define(first, {"If-Match": '"3"'})).json()["revision"] == 4


async def test_a_file_defines_removed_ones_anew_and_says_with_which_revision(house: House) -> None:
    await defined(house)
    await remove(house)
    plant = house.projection.site.plant
    material, machine, ability = next(iter(plant.materials)), next(iter(plant.machines)), plant.abilities[0]
    row = f"bracket,Bracket,2,{ability},{material},2,{machine},12.5"
    file = {"csv": f"product,name,lot,ability,material,pieces,machine,cycle_s\n{row}\n"}
    for dry in (True, False):
        answer = await house.client.post("/api/products/import", json=file | {"dry_run": dry})
        assert [(each["becomes"], each["revision"]) for each in answer.json()["products"]] == [("new", 3)]
    assert (await house.get(PATH))["revision"] == 3


async def test_what_was_read_before_a_removal_does_not_bring_it_back(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    await defined(house)
    read, go_on = asyncio.Event(), asyncio.Event()
    usual = Products.defined

    async def slow(self: Products) -> list[DefinedProduct]:
        found = await usual(self)
        read.set()
        await go_on.wait()
        return found

    # The gateway does not know it at first, as after a start.
    known = provided(house.app, Catalogue)
    known._go_by([], ["bracket"])
    with monkeypatch.context() as slowly:
        slowly.setattr(Products, "defined", slow)
        looking = asyncio.create_task(look(house))
        await read.wait()
    await remove(house)
    go_on.set()
    await looking
    assert "bracket" not in await listed(house)
    await look(house)
    assert "bracket" not in await listed(house)


async def test_a_look_while_the_removal_is_written_does_not_bring_it_back(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    await defined(house)
    known = provided(house.app, Catalogue)
    usual = known._go_by

    async def looks_meanwhile(*_: object) -> None:
        usual([], {"bracket"})
        await look(house)

    monkeypatch.setattr(known, "_removing", {"bracket"})
    await looks_meanwhile()
    assert "bracket" not in await listed(house)


async def test_a_removal_that_was_not_written_leaves_it_there(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    await defined(house)

    async def died(*_: object) -> None:
        raise UnavailableError("database", "it went away", "start it again")

    with monkeypatch.context() as dying:
        dying.setattr(Products, "remove", died)
        problem(await remove(house), 503, "database-away")
    known = provided(house.app, Catalogue)
    # At the worst it is forgotten before that.
    known._go_by([], {"bracket"})
    await look(house)
    assert "bracket" in await listed(house)
    assert (await remove(house)).status_code == 204


async def test_a_product_of_the_plant_file_stays(house: House) -> None:
    told = problem(await remove(house, PRODUCT), 409, "product-in-plant-file")
    assert "plant file" in told["detail"]
    assert (await removed(house, PRODUCT))[PRODUCT]["result"] == "in_plant_file"
    assert PRODUCT in await listed(house)


async def test_an_order_that_has_not_ended_keeps_it_and_one_that_has_ended_keeps_its_name(
    house: House,
) -> None:
    await defined(house)
    items = [{"product": "bracket", "quantity": 1}]
    stored, released = [await house.place(items=items, release=release) for release in (False, True)]
    told = problem(await remove(house), 409, "product-needed")
    [error] = told["errors"]
    assert (error["code"], error["values"]["count"]) == ("needed_by_order", "2")
    assert error["values"]["names"] == ", ".join(sorted((stored["id"], released["id"])))
    assert error["reason"] in told["detail"]
    for order in (stored, released):
        cancelled = await house.client.post(f"/api/orders/{order['id']}/cancel")
        assert cancelled.status_code == 200, cancelled.text
    assert (await remove(house)).status_code == 204
    assert (await house.get(f"/api/orders/{released['id']}"))["items"][0]["product"] == "bracket"
    token = released["tracking_url"].rpartition("/")[2]
    found = await facts_of(house.store, house.projection, token, house.wall.now_s)
    assert found.facts is not None
    assert found.facts.names["bracket"] == "Bracket"


async def test_the_names_of_what_needs_it_are_few_and_only_for_who_may_see_orders(
    house: House, visitor: httpx.AsyncClient
) -> None:
    await defined(house)
    for _ in range(7):
        await house.place(items=[{"product": "bracket", "quantity": 1}])
    [error] = problem(await remove(house), 409, "product-needed")["errors"]
    names = error["values"]["names"].split(", ")
    assert (len(names), names[-1], error["values"]["count"]) == (6, "…", "7")
    _, floor = await house.key(Scope.FLOOR_WRITE)
    [error] = problem(await visitor.delete(PATH, headers=floor), 409, "product-needed")["errors"]
    assert error["values"] == {"count": "7", "names": "…"}


async def test_recurring_orders_keep_it_also_while_they_are_paused(house: House) -> None:
    await defined(house)
    order = {"customer": "Hall 3", "items": [{"product": "bracket", "quantity": 2}]}
    await added(house, transport=None, order=order, paused=True)
    [error] = problem(await remove(house), 409, "product-needed")["errors"]
    assert (error["code"], error["values"]) == ("needed_by_schedule", {"count": "1", "names": "Shafts"})


async def test_a_goal_of_a_machine_keeps_it(house: House) -> None:
    await defined(house)
    goal = GoalBrief(goal="strategist.1-1", product="bracket", quantity=2, made=0, delivered=0)
    await house.say([machine_heartbeat("M3", 1, goals=(goal,))])
    [error] = problem(await remove(house), 409, "product-needed")["errors"]
    assert (error["code"], error["values"]) == ("needed_by_machine", {"count": "1", "names": "M3"})
    await house.say([machine_heartbeat("M3", 2)])
    assert (await remove(house)).status_code == 204


async def test_a_part_stays_with_the_product_that_needs_it_and_goes_with_it(house: House) -> None:
    await defined(house, "part", "whole", "other")
    plant = house.projection.site.plant
    whole = replace(plant.products["whole"], bill=(BillLine("part", 1),))
    house.projection.site.change_products([(whole, {})])
    [error] = problem(await remove(house, "part"), 409, "product-needed")["errors"]
    assert (error["code"], error["values"]["names"]) == ("needed_by_product", "whole")
    await house.place(items=[{"product": "whole", "quantity": 1}])
    kept = await removed(house, "part", "whole", "other")
    assert {id_: each["result"] for id_, each in kept.items()} == {
        "part": "needed",
        "whole": "needed",
        "other": "removed",
    }
    for order in (await house.get("/api/orders"))["items"]:
        await house.client.post(f"/api/orders/{order['id']}/cancel")
    assert {each["result"] for each in (await removed(house, "part", "whole")).values()} == {"removed"}


async def test_of_several_each_says_what_became_of_it(house: House) -> None:
    await defined(house, "B1", "B2", "B3")
    order = await house.place(items=[{"product": "B2", "quantity": 1}])
    found = await removed(house, "B1", "B2", "nothing", PRODUCT, "B1")
    assert {id_: each["result"] for id_, each in found.items()} == {
        "B1": "removed",
        "B2": "needed",
        "nothing": "unknown",
        PRODUCT: "in_plant_file",
    }
    [reason] = found["B2"]["reasons"]
    assert reason["values"]["names"] == order["id"]
    assert {"B1", "B2", "B3"} & await listed(house) == {"B2", "B3"}
    line, *_ = await house.audit(action="product.remove_several")
    assert msgspec.json.decode(line.detail) == {"products": 4, "removed": ["B1"]}
    # Sent once more, it does no harm.
    assert (await removed(house, "B1"))["B1"]["result"] == "unknown"


async def test_only_who_may_define_products_removes_them(house: House, visitor: httpx.AsyncClient) -> None:
    await defined(house)
    _, orders = await house.key(Scope.ORDERS_WRITE)
    problem(await visitor.delete(PATH, headers=orders), 403, "not-allowed")
    several = await visitor.post("/api/products/remove", json={"products": ["bracket"]}, headers=orders)
    problem(several, 403, "not-allowed")
    _, floor = await house.key(Scope.FLOOR_WRITE)
    assert (await visitor.delete(PATH, headers=floor)).status_code == 204


async def test_with_if_match_only_that_revision_is_removed(house: House) -> None:
    await defined(house)
    await define(house, {"If-Match": '"1"'}, lot=3)
    problem(await remove(house, **{"If-Match": '"1"'}), 412, "changed-since")
    assert (await remove(house, **{"If-Match": '"2"'})).status_code == 204


async def test_what_is_removed_makes_room_for_others(house: House, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(catalogue, "PRODUCTS_MAX", 4)
    await defined(house, "B1", "B2")
    told = problem(await define(house, NEW, "B3"), 429, "share-used")
    assert "POST /api/products/remove" in told["detail"]
    await remove(house, "B1")
    await defined(house, "B3")
    problem(await define(house, NEW, "B1"), 429, "share-used")


async def test_one_that_does_not_fit_the_plant_any_more_is_listed_removed_and_defined_anew(url: str) -> None:
    levels = load_plant("levels").file
    async with gateway(url, plant=levels) as house:
        for id_ in ("A1", "A2"):
            machine = next(iter(house.projection.site.plant.machines))
            answer = await define(house, NEW, id_, bill={"bar": 1}, machines={machine: 5.0})
            assert answer.status_code == 201, answer.text
        async with house.store.write() as work:
            for row in await work.products.defined():
                gone = row.definition.replace('"bar"', '"gone"')
                await work.products.define(replace(row, definition=gone, revision=2))
    async with gateway(url, plant=levels) as house:
        states = {
            each["id"]: each["state"] for each in (await house.get("/api/product-definitions"))["items"]
        }
        assert states == {"A1": "unfit", "A2": "unfit"}
        assert (await remove(house, "A1")).status_code == 204
        machine = next(iter(house.projection.site.plant.machines))
        again = await define(house, NEW, "A2", bill={"bar": 1}, machines={machine: 5.0})
        assert (again.status_code, again.json()["revision"]) == (201, 3)
        for state, id_, asked in (("made", "A2", {}), ("removed", "A1", {"removed": True})):
            [found] = (await house.get("/api/product-definitions", **asked))["items"]
            assert (found["id"], found["state"], found["by"]) == (id_, state, "Administrator")


async def test_of_removed_ones_that_no_order_names_only_the_last_are_remembered(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(products, "REMOVED_KEPT", 2)
    await defined(house, "ordered", "B1", "B2", "B3")
    order = await house.place(items=[{"product": "ordered", "quantity": 1}])
    await house.client.post(f"/api/orders/{order['id']}/cancel")
    for id_ in ("ordered", "B1", "B2", "B3"):
        await remove(house, id_)
    async with house.store.read() as work:
        known = {each.id for each in await work.products.removed(100)}
        before = await work.products.mark()
    assert known == {"ordered", "B2", "B3"}
    await defined(house, "B1")
    async with house.store.read() as work:
        assert await work.products.mark() != before
    assert (await house.get("/api/products/B1"))["revision"] == 1


async def test_one_that_has_come_into_the_plant_file_begins_anew_there(house: House, url: str) -> None:
    await defined(house)
    await remove(house)
    file = house.projection.site.plant.file
    bracket = replace(file.products[0], id="bracket", name="Bracket")
    making = replace(file.machines[0].makes[0], product="bracket")
    machine = replace(file.machines[0], makes=(*file.machines[0].makes, making))
    plant = replace(file, products=(*file.products, bracket), machines=(machine, *file.machines[1:]))
    async with gateway(url, plant=plant) as next_one:
        assert (await next_one.get(PATH))["revision"] == 1
        fields = body(next_one) | {"machines": {}}
        changed = await next_one.client.put(PATH, json=fields, headers={"If-Match": '"1"'})
        assert (changed.status_code, changed.json()["revision"]) == (200, 2)
