"""What there is and where, over REST."""

from __future__ import annotations

import msgspec
import pytest
from fake_bus import PLANT
from gateway_kit import House
from heartbeats import atv_heartbeat, machine_heartbeat

from dray.gateway.access.principal import Role
from dray.messages import BufferLevel, StationHeartbeat, StockLevel

pytestmark = pytest.mark.anyio

MATERIAL, OTHER = PLANT.materials[0].id, PLANT.materials[1].id
PRODUCT = PLANT.products[0].id


def tell(house: House) -> None:
    """M1 has material, and pieces of which some are spare; ATV1 carries some."""
    house.bus.say(
        machine_heartbeat(
            "M1",
            buffers=(BufferLevel(item=MATERIAL, level=7, capacity=60, on_order=20),),
            goods=(BufferLevel(item=PRODUCT, level=5, capacity=30, spare=2),),
        ),
        atv_heartbeat("ATV1", load=MATERIAL, load_quantity=20),
    )


async def test_the_inventory_tells_what_there_is_where_and_what_is_spare(house: House) -> None:
    tell(house)
    lines = (await house.get("/api/inventory"))["items"]
    told = {(line["item"], line["place"]): line for line in lines}
    assert set(told) == {(MATERIAL, "M1"), (PRODUCT, "M1"), (MATERIAL, "ATV1")}
    goods = told[PRODUCT, "M1"]
    assert (goods["kind"], goods["quantity"], goods["spare"], goods["capacity"]) == ("goods", 5, 2, 30)
    buffer = told[MATERIAL, "M1"]
    assert (buffer["kind"], buffer["quantity"], buffer["on_order"]) == ("buffer", 7, 20)
    assert (told[MATERIAL, "ATV1"]["kind"], told[MATERIAL, "ATV1"]["quantity"]) == ("on_board", 20)


async def test_the_inventory_is_narrowed_down_and_comes_in_pages(house: House) -> None:
    tell(house)
    assert [line["place"] for line in (await house.get("/api/inventory", item=MATERIAL))["items"]] == [
        "ATV1",
        "M1",
    ]
    assert [line["item"] for line in (await house.get("/api/inventory", place="ATV1"))["items"]] == [MATERIAL]
    first = await house.get("/api/inventory", limit=2)
    rest = await house.get("/api/inventory", limit=2, cursor=first["next_cursor"])
    assert (len(first["items"]), len(rest["items"]), rest["next_cursor"]) == (2, 1, None)


async def test_materials_tell_how_much_of_them_there_is(house: House) -> None:
    tell(house)
    materials = {each["id"]: each for each in (await house.get("/api/materials"))["items"]}
    assert set(materials) == {each.id for each in PLANT.materials}
    one = materials[MATERIAL]
    assert (one["at_machines"], one["on_board"], one["on_order"]) == (7, 20, 20)
    assert one["storages"] == [
        each.id for each in PLANT.storages if any(stock.material == MATERIAL for stock in each.stocks)
    ]
    assert (materials[OTHER]["at_machines"], materials[OTHER]["on_board"]) == (0, 0)


async def test_storages_tell_what_they_hold_when_they_are_full(house: House) -> None:
    storages = (await house.get("/api/storages"))["items"]
    assert [each["id"] for each in storages] == sorted(each.id for each in PLANT.storages)
    stocks = {each.id: each.stocks for each in PLANT.storages}
    for each in storages:
        assert [(stock["material"], stock["capacity"]) for stock in each["stocks"]] == [
            (stock.material, stock.capacity) for stock in stocks[each["id"]]
        ]


async def test_storages_tell_what_lies_there_and_what_is_promised(house: House) -> None:
    kept = PLANT.storages[0].stocks[0]
    level = StockLevel(item=kept.material, level=9, capacity=kept.capacity, promised=5, wanted=10)
    beat = StationHeartbeat(station=PLANT.storages[0].id, incarnation=1, seq=2, at_s=7.0, stocks=(level,))
    late = msgspec.structs.replace(beat, seq=1, stocks=())
    house.bus.say(beat, late)
    storages = {each["id"]: each for each in (await house.get("/api/storages"))["items"]}
    told = storages[PLANT.storages[0].id]
    assert told["stocks"][0] == {
        "material": kept.material,
        "capacity": kept.capacity,
        "level": 9,
        "promised": 5,
        "on_order": 0,
        "wanted": 10,
    }
    assert told["seen_at_s"] is not None
    silent = storages[PLANT.storages[1].id]
    assert (silent["seen_at_s"], silent["stocks"][0]["level"]) == (None, None)


async def test_operators_see_what_lies_in_their_areas(house: House) -> None:
    tell(house)
    nowhere = await house.log_in("ana", Role.OPERATOR)
    for noun in ("inventory", "storages"):
        assert (await nowhere.get(f"/api/{noun}")).json()["items"] == []
    materials = (await nowhere.get("/api/materials")).json()["items"]
    assert {(each["at_machines"], each["on_board"], tuple(each["storages"])) for each in materials} == {
        (0, 0, ())
    }
    everywhere = await house.log_in("eve", Role.OPERATOR, *(area.id for area in PLANT.areas))
    seen = (await everywhere.get("/api/inventory")).json()["items"]
    assert "M1" in {line["place"] for line in seen}
