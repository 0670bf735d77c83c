"""The largest bodies that a route takes: those that mean something, by route, and those that were made to be slow to refuse, of any schema."""

from __future__ import annotations

import json
from base64 import b64encode
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import msgspec
from gateway_kit import PRODUCT, draft

from dray.gateway.http.csv_rows import MAX_ROWS
from dray.gateway.orders.drafts import MAX_ITEMS
from dray.gateway.routes.factory.plant_drafts import MAX_PLAN_BYTES
from dray.gateway.routes.products.removal import REMOVED_AT_ONCE
from dray.plant import default_plant, plant_yaml

Json = Mapping[str, Any]

MARGIN_BYTES = 64
"""Of a body, for what stands around what fills it."""


def filled(one: str, size: int) -> str:
    """As many of these, parted by commas, as have room."""
    return ",".join([one] * (size // (len(one) + 1)))


def orders_file(_size: int) -> Json:
    rows = "".join(f"Hall {number},{number},{PRODUCT},1,2030-05-01T12:00:00Z\n" for number in range(MAX_ROWS))
    return {"csv": f"customer,reference,product,quantity,due_at\n{rows}"}


def faulty_orders(size: int) -> Json:
    row = "Hall,,nothing,many,soon,perhaps," + "x" * (size // MAX_ROWS - 40) + "\n"
    return {"csv": "customer,reference,product,quantity,due_at,release,priority\n" + row * MAX_ROWS}


def as_bytes(text: str, size: int, encoding: str) -> str:
    """A text as a file in base64, filled up with empty lines to as many bytes as have room."""
    room = (size - MARGIN_BYTES) // 4 * 3
    content = text.encode(encoding)
    assert len(content) <= room
    line = "\n".encode(encoding.replace("-sig", ""))
    return b64encode(content + line * ((room - len(content)) // len(line))).decode()


def orders_bytes(size: int) -> Json:
    """A file that is read as what it does not say, of orders that were placed already."""
    text = str(orders_file(size)["csv"]).replace("Hall 0,", "H\xe4ll 0,")
    return {"base64": as_bytes(text, size, "cp1252"), "dry_run": True}


def faulty_orders_bytes(size: int) -> Json:
    row = "Hall,,nothing,many,soon,perhaps," + "x" * (size // MAX_ROWS // 3 - 40) + "\n"
    head = "customer,reference,product,quantity,due_at,release,priority\n"
    return {"base64": as_bytes(head + row * MAX_ROWS, size, "utf-16-le")}


def products_file(_size: int) -> Json:
    plant = default_plant()
    product = plant.products[PRODUCT]
    line, machine = product.bill[0], plant.machines_for(PRODUCT)[0]
    rows = "".join(
        f"X{number},Bracket,{product.lot},{line.material},{line.quantity},{machine},12.5\n"
        for number in range(MAX_ROWS)
    )
    return {"csv": f"product,name,lot,material,pieces,machine,cycle_s\n{rows}"}


def products_bytes(size: int) -> Json:
    return {"base64": as_bytes(str(products_file(size)["csv"]), size, "utf-16-le"), "dry_run": True}


def products_to_remove(_size: int) -> Json:
    return {"products": [f"X{number}" for number in range(REMOVED_AT_ONCE)]}


def large_draft(size: int) -> Json:
    """A draft with as many lists as have room: each takes most in memory and in YAML, for its length."""
    return {"name": "Line 4", "data": {"nodes": json.loads(f"[{filled('[]', size - MARGIN_BYTES)}]")}}


def plant_draft(size: int) -> Json:
    """A draft with as many places and lanes as have room, none of them like another."""
    data = msgspec.to_builtins(default_plant().file)
    count = size // 150
    data["nodes"] = [
        {"id": f"n{at}", "x_m": at % 80 + 0.5, "y_m": at // 80 % 50 + 0.5} for at in range(count)
    ]
    data["lanes"] = [
        {"start": f"n{at}", "end": f"n{at + 1}", "speed_limit_mps": 1.5, "both_ways": True}
        for at in range(count - 1)
    ]
    return {"name": "Line 4", "data": data}


def plant_text(_size: int) -> Json:
    return {"name": "Line 4", "file": plant_yaml(default_plant()), "onto_running": True}


def nested_text(size: int) -> Json:
    return {"name": "Line 4", "file": f"nodes: [{filled('[]', size - MARGIN_BYTES)}]"}


def layout_bytes(size: int) -> Json:
    """A LIF file with as many nodes and edges as have room, in an encoding of its own."""
    room, types = (size - MARGIN_BYTES) // 4 * 3 - 2 * MARGIN_BYTES, [{"vehicleTypeId": "t"}]
    count = room // 200
    nodes = [{"nodeId": f"\xe4{at}", "nodePosition": {"x": at % 80, "y": at // 80}} for at in range(count)]
    edges = [
        {
            "edgeId": f"e{at}",
            "startNodeId": f"\xe4{at}",
            "endNodeId": f"\xe4{at + 1}",
            "vehicleTypeEdgeProperties": types,
        }
        for at in range(count - 1)
    ]
    text = json.dumps({"layouts": [{"layoutId": "L", "nodes": nodes, "edges": edges}]}, ensure_ascii=False)
    return {"name": "Line 4", "file_base64": as_bytes(text, size, "cp1252"), "onto_running": True}


def nested_bytes(size: int) -> Json:
    room = (size - MARGIN_BYTES) // 4 * 3 - MARGIN_BYTES
    return {"name": "Line 4", "file_base64": as_bytes(f"nodes: [{filled('[]', room)}]", size, "utf-8-sig")}


def picture(_size: int) -> Json:
    content = b"\x89PNG\r\n\x1a\n".ljust(MAX_PLAN_BYTES, b"\0")
    return {"media_type": "image/png", "base64": b64encode(content).decode()}


def large_order(_size: int) -> Json:
    return draft(items=[{"product": PRODUCT, "quantity": 1}] * MAX_ITEMS, customer="x" * 200)


def work(size: int) -> Json:
    order = large_order(size)
    return {"items": order["items"]}


LARGEST: dict[tuple[str, str], tuple[Callable[[int], Json], ...]] = {
    ("POST", "/api/people"): (),
    ("PUT", "/api/people/{person}/secret"): (),
    ("PUT", "/api/people/{person}/areas"): (),
    ("POST", "/api/keys"): (),
    ("PUT", "/api/products/{product}"): (),
    ("POST", "/api/products/remove"): (products_to_remove,),
    ("POST", "/api/products/import"): (products_file, products_bytes),
    ("POST", "/api/tasks/{task}/load"): (),
    ("POST", "/api/machines/{machine}/commands"): (),
    ("POST", "/api/stations/{station}/commands"): (),
    ("POST", "/api/atvs/{atv}/commands"): (),
    ("POST", "/api/atvs/{atv}/carried-away"): (),
    ("POST", "/api/atvs/{atv}/put-back"): (),
    ("POST", "/api/alerts/{alert}/acknowledge"): (),
    ("PUT", "/api/duty"): (),
    ("POST", "/api/calls/{call}/answer"): (),
    ("POST", "/api/agents/{agent}/shut-out"): (),
    ("POST", "/api/closures"): (),
    ("POST", "/api/closures/preview"): (),
    ("POST", "/api/areas/{area}/pause"): (),
    ("POST", "/api/plant-drafts"): (plant_text, nested_text, layout_bytes, nested_bytes),
    ("PUT", "/api/plant-drafts/{draft}"): (plant_draft, large_draft),
    ("PUT", "/api/plant-drafts/{draft}/plan"): (picture,),
    ("POST", "/api/plant-drafts/{draft}/play"): (),
    ("POST", "/api/obstacles/cleared"): (),
    ("PUT", "/api/reports/targets"): (),
    ("POST", "/api/orders"): (large_order,),
    ("POST", "/api/orders/{order}/links"): (),
    ("POST", "/api/orders/import"): (orders_file, faulty_orders, orders_bytes, faulty_orders_bytes),
    ("POST", "/api/orders/preview"): (work,),
    ("PATCH", "/api/orders/{order}"): (work,),
    ("POST", "/api/transports"): (),
    ("POST", "/api/transports/{transport}/links"): (),
    ("POST", "/api/schedules"): (),
    ("POST", "/api/schedules/preview"): (),
    ("PATCH", "/api/schedules/{schedule}"): (),
    ("POST", "/api/faults"): (),
}
"""Bodies that mean something, by route and how many bytes they may have. Where there is none, a body is small unless it is refused."""


def hostile(schema: Json, definitions: Mapping[str, Json], size: int) -> Iterator[tuple[str, bytes]]:
    """Bodies of this size that are slow to refuse, and what they are: wherever a value may stand in the schema, far too much of it."""
    size -= MARGIN_BYTES
    yield "unclosed lists", b"[" * size
    yield "numbers", f"[{filled('0', size)}]".encode()
    yield "unknown fields", ("{" + ",".join(f'"{at:x}":0' for at in range(size // 9)) + "}").encode()
    for before, after in _places(schema, definitions, 3):
        room = size - len(before) - len(after)
        for what, value in (
            ("lists", f"[{filled('[]', room)}]"),
            ("objects", f"[{filled('{}', room)}]"),
            ("entries", "{" + ",".join(f'"{at:x}":0' for at in range(room // 9)) + "}"),
            ("text", '"' + "a" * room + '"'),
        ):
            yield f"{what} in {before}", (before + value + after).encode()


def _places(schema: Json, definitions: Mapping[str, Json], levels: int) -> Iterator[tuple[str, str]]:
    """What stands before and after each place for a value."""
    if (name := schema.get("$ref", "").rpartition("/")[2]) and levels:
        yield from _places(definitions[name], definitions, levels - 1)
    for choice in (*schema.get("anyOf", ()), *schema.get("oneOf", ())):
        yield from _places(choice, definitions, levels)
    for field, inner in schema.get("properties", {}).items():
        opened = f'{{"{field}":'
        yield opened, "}"
        for before, after in _places(inner, definitions, levels):
            yield opened + before, after + "}"
    if isinstance(items := schema.get("items"), dict):
        for before, after in _places(items, definitions, levels):
            yield f"[{before}", f"{after}]"
