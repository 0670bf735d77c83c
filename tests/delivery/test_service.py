"""`dray up` as a process: what it promises to whoever starts, stops or kills it."""

from __future__ import annotations

import json
import signal
import sqlite3
import time
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from plants import plant_file
from variants import variants
from websockets.sync.client import ClientConnection, connect

from dray.plant import Plant, plant_yaml

SPEED = ("--speed", "50", "--no-demand")

DELIVERED_S = 180.0
"""Within a minute of real time at this speed, an order of a few pieces is delivered."""


def order(dray: Any, quantity: int, key: str) -> dict[str, Any]:
    """Order the plant's first product."""
    product = dray.ask("/api/products")["items"][0]["id"]
    body = {"customer": "Hall 3", "items": [{"product": product, "quantity": quantity}]}
    return dict(dray.ask("/api/orders", body, **{"Idempotency-Key": key}))


def stream(dray: Any) -> ClientConnection:
    """The websocket of the panels, as the administrator."""
    headers = {"Authorization": f"Bearer {dray.token}"}
    return connect(f"{dray.url.replace('http', 'ws')}/api/stream", additional_headers=headers, max_size=None)


def watch(dray: Any, order_id: str, status: str) -> dict[str, Any]:
    """Listen to the stream until the order has this status; the order as its frames have told it."""
    ends_s = time.monotonic() + DELIVERED_S
    view: dict[str, Any] = {}
    with stream(dray) as frames:
        while view.get("status") != status:
            frame = json.loads(frames.recv(timeout=ends_s - time.monotonic()))
            for patch in frame.get("orders", ()):
                if patch["id"] == order_id:
                    view |= patch
    return view


@pytest.mark.slow
@pytest.mark.parametrize("by", variants([signal.SIGTERM, signal.SIGINT]))
def test_a_signal_stops_it_cleanly_while_a_browser_watches(start_dray, by) -> None:
    dray = start_dray("--speed", "20")
    with stream(dray) as frames:
        frames.recv(timeout=60)
        assert dray.stop(by) == 0, dray.output()
    assert "Traceback" not in dray.output()


@pytest.mark.slow
def test_a_plant_of_one_product_gets_its_demand(start_dray, tmp_path: Path) -> None:
    file = tmp_path / "one.yaml"
    file.write_text(plant_yaml(Plant(plant_file())))
    dray = start_dray("--speed", "50", "--plant", str(file))
    ends_s = time.monotonic() + DELIVERED_S
    while not dray.ask("/api/orders")["items"] and time.monotonic() < ends_s:
        time.sleep(0.2)
    assert dray.ask("/api/orders")["items"][0]["customer"] == "Simulated demand"
    assert dray.stop() == 0
    assert "Traceback" not in dray.output()


def test_an_order_over_rest_is_delivered_and_its_events_tell_every_auction(
    start_dray, tmp_path: Path
) -> None:
    database = tmp_path / "dray.db"
    dray = start_dray(*SPEED, url=f"sqlite:///{database}")
    placed = order(dray, 4, "k-1")
    assert placed["status"] == "released"
    view = watch(dray, placed["id"], "delivered")
    assert view["items"][0]["delivered"] == 4
    assert dray.stop() == 0, dray.output()  # what has been heard is written by now

    kinds: dict[str | None, set[str]] = {}
    with closing(sqlite3.connect(database)) as rows:
        for task, kind in rows.execute("SELECT task, kind FROM events"):
            kinds.setdefault(task, set()).add(kind)
    assert {"OrderAccepted", "OrderFulfilled", "GoodsDelivered"} <= set().union(*kinds.values())
    auctions = [told for task, told in kinds.items() if task is not None and "TaskClosed" in told]
    assert len(auctions) >= 2, "the goal, and the way of the goods to the delivery warehouse"
    for told in auctions:
        assert {
            "TaskOpened",
            "BidSent",
            "BidReceived",
            "AwardGiven",
            "AwardAnswered",
            "ContractTaken",
        } <= told


@pytest.mark.slow
def test_an_accepted_order_survives_a_kill_and_is_delivered_once(start_dray, url: str) -> None:
    dray = start_dray(*SPEED, url=url)
    placed = order(dray, 6, "k-2")
    watch(dray, placed["id"], "in_production")
    dray.kill()

    dray = start_dray(*SPEED, url=url)
    again = order(dray, 6, "k-2")
    assert again["id"] == placed["id"], "the key is remembered: no second order"
    view = watch(dray, placed["id"], "delivered")
    assert [item["delivered"] for item in view["items"]] == [6]
    assert len(dray.ask("/api/orders")["items"]) == 1
    assert dray.stop() == 0, dray.output()


@pytest.mark.slow
def test_a_second_one_on_the_same_port_is_told_so_and_the_first_goes_on(start_dray) -> None:
    dray = start_dray(*SPEED)
    port = dray.url.rpartition(":")[2]
    with pytest.raises(pytest.fail.Exception, match=rf"port {port} on 127\.0\.0\.1.*in use.*--port"):
        start_dray("--port", port)
    assert dray.ask("/readyz")["status"] == "ready"
    assert dray.stop() == 0, dray.output()
