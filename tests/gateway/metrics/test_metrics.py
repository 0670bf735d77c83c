"""Metrics: what was done is counted once, and nothing that others write becomes a label."""

from __future__ import annotations

import re

import pytest
from gateway_kit import PRODUCT, House, draft, gateway
from heartbeats import atv_heartbeat, events, machine_heartbeat
from prometheus_client.parser import text_string_to_metric_families

from dray.gateway.access.principal import ADMIN
from dray.messages import AtvStatus, Link, Reason, Role, Transport, TransportCost
from dray.messages.contract import Refusal
from dray.messages.fact import (
    AnyFact,
    AwardAnswered,
    BidReceived,
    BidRefused,
    CarrierChanged,
    GoodsDelivered,
    OrderAccepted,
    OrderFulfilled,
    PrimarySuspected,
    RoundFailed,
    TaskClosed,
    TaskOpened,
    TookOver,
)

pytestmark = pytest.mark.anyio

FETCH = Transport(item="steel", quantity=4, sources=("S1",), destination="M1", ability="tote")

Series = dict[str, float]


async def scrape(house: House) -> Series:
    """All samples, by name and labels as Prometheus writes them."""
    answer = await house.client.get("/metrics")
    assert answer.status_code == 200
    assert answer.headers["content-type"].startswith("text/plain")
    found: Series = {}
    for family in text_string_to_metric_families(answer.text):
        for sample in family.samples:
            labels = ",".join(f"{name}={value}" for name, value in sorted(sample.labels.items()))
            found[f"{sample.name}{{{labels}}}" if labels else sample.name] = sample.value
    return found


def opened(round_: int = 1) -> TaskOpened:
    return TaskOpened(
        task="M1-1",
        epoch=1,
        role=Role.PRIMARY,
        round=round_,
        work=FETCH,
        radius_m=20.0,
        deadline_s=900.0,
        bids_until_s=105.0,
    )


def bid(bidder: str) -> BidReceived:
    cost = TransportCost(empty_way_s=1.0, loaded_way_s=1.0, energy_s=0.0, suitability_s=0.0)
    return BidReceived(
        task="M1-1", epoch=1, role=Role.PRIMARY, round=2, bidder=bidder, cost=cost, total_s=2.0, finish_s=9.0
    )


AUCTION: tuple[AnyFact, ...] = (
    opened(1),
    RoundFailed(task="M1-1", epoch=1, role=Role.PRIMARY, round=1, bids=0, next_round_s=103.0),
    opened(2),
    bid("ATV1"),
    bid("ATV2"),
    AwardAnswered(task="M1-1", epoch=1, role=Role.PRIMARY, bidder="ATV1", answer="accepted"),
    PrimarySuspected(task="M1-1", epoch=1, primary="ATV1", silent_s=3.5),
    CarrierChanged(task="M1-1", epoch=2, replaced="ATV1", carrier="ATV2", reason=Reason.SILENT),
    TaskClosed(task="M1-1", epoch=2, outcome="delivered", carrier="ATV2"),
)
"""Two rounds, a takeover and a handover; one second between each and the next."""


async def test_an_auction_is_measured_with_its_rounds_and_bids(house: House) -> None:
    house.bus.say(*events("M1", *AUCTION))
    house.bus.say(
        *events("ATV2", TookOver(task="M1-1", epoch=2, primary="ATV1", silent_s=3.5, reason=Reason.SILENT))
    )
    told = await scrape(house)
    assert told["dray_tasks_opened_total{work=transport}"] == 1
    assert told["dray_auction_duration_seconds_sum{role=primary}"] == 5.0
    assert told["dray_auction_rounds_sum{role=primary}"] == 2
    assert told["dray_auction_rounds_failed_total{role=primary}"] == 1
    # None in the first round, and two in the second.
    assert told["dray_auction_bids_count{role=primary}"] == 2
    assert told["dray_auction_bids_sum{role=primary}"] == 2
    assert told["dray_primaries_suspected_total"] == 1
    assert told["dray_carriers_changed_total{to=secondary}"] == 1
    assert told["dray_takeovers_total"] == 1
    assert told["dray_tasks_closed_total{outcome=delivered,work=transport}"] == 1
    assert told["dray_transport_duration_seconds_sum"] == 8.0


async def test_what_is_said_twice_is_counted_once_but_as_two_messages(house: House) -> None:
    house.bus.say(*events("M1", *AUCTION), *events("M1", *AUCTION))
    told = await scrape(house)
    assert told["dray_tasks_opened_total{work=transport}"] == 1
    assert told["dray_bus_messages_heard_total{kind=Event}"] == 2 * len(AUCTION)
    # The same number in another life is another fact.
    house.bus.say(*events("M1", opened(), life=2))
    assert (await scrape(house))["dray_tasks_opened_total{work=transport}"] == 2


async def test_refusals_deliveries_and_heartbeats_are_counted(house: House) -> None:
    refusal = BidRefused(task="M1-1", epoch=1, role=Role.PRIMARY, reason=Refusal.BATTERY)
    goods = GoodsDelivered(goal="G1", order="O-1", item=0, product=PRODUCT, quantity=3, delivered=3)
    house.bus.say(*events("ATV1", refusal), *events("M1", goods))
    house.bus.say(atv_heartbeat("ATV1"), atv_heartbeat("ATV2", link=Link.MESH, status=AtvStatus.WORKING))
    house.bus.say(machine_heartbeat("M1"))
    told = await scrape(house)
    assert told["dray_bids_refused_total{reason=battery}"] == 1
    assert told["dray_pieces_delivered_total"] == 3
    assert told["dray_heartbeats_heard_total{agent_kind=atv,link=mesh}"] == 1
    assert told["dray_heartbeats_heard_total{agent_kind=machine,link=wlan}"] == 1
    assert told["dray_atvs{status=working}"] == 1
    assert told["dray_atvs{status=error}"] == 0
    assert told["dray_machines{status=idle}"] == 1


async def test_orders_and_pieces_are_counted_and_not_how_often_they_are_told(house: House) -> None:
    """A strategist takes the order over, and the first one comes back and tells its end again."""
    taken = OrderAccepted("O-1", ("G1",), held=1)
    some, all_of_it = (
        GoodsDelivered("G1", "O-1", 0, PRODUCT, quantity, delivered)
        for quantity, delivered in ((3, 3), (5, 5))
    )
    house.bus.say(
        *events("strategist", taken, some), *events("strategist2", all_of_it, OrderFulfilled("O-1"))
    )
    house.bus.say(*events("strategist", taken, OrderFulfilled("O-1"), life=2))
    told = await scrape(house)
    assert told["dray_orders_accepted_total"] == 1
    assert told["dray_orders_fulfilled_total"] == 1
    assert told["dray_pieces_delivered_total"] == 5
    house.bus.say(*events("strategist", OrderFulfilled("O-2"), life=2, first=3))
    assert (await scrape(house))["dray_orders_fulfilled_total"] == 2


async def test_orders_and_the_database_are_told(house: House) -> None:
    await house.place()
    await house.place(release=False)
    told = await scrape(house)
    assert told["dray_orders_open{status=released}"] == 1
    assert told["dray_orders_open{status=stored}"] == 1
    assert told["dray_orders_open{status=in_delivery}"] == 0
    assert told["dray_database_up"] == 1
    assert told["dray_database_ping_seconds"] > 0
    assert told["dray_historian_up"] == 1
    assert told["dray_historian_behind_seconds"] == 0
    assert told["dray_bus_joined"] == 1
    assert told["dray_strategist_present"] == 0


async def test_what_the_historian_has_written_is_counted(house: House) -> None:
    await house.say(events("M1", *AUCTION))
    assert (await scrape(house))["dray_historian_events_kept_total"] == len(AUCTION)


async def test_panels_are_counted_with_their_frames(house: House) -> None:
    hub = house.hub
    client = hub.join(ADMIN)
    assert client is not None
    await client.next_frame()
    house.bus.say(atv_heartbeat())
    hub.tick()
    told = await scrape(house)
    assert told["dray_stream_clients"] == 1
    assert told["dray_stream_snapshots_total"] == 1
    assert told["dray_stream_frames_total"] >= 1


async def test_requests_are_timed_by_route_and_never_by_path(house: House) -> None:
    name = (await house.place())["id"]
    await house.get(f"/api/orders/{name}")
    await house.client.get("/api/orders/O-unknown")
    await house.client.get(f"/nowhere/{name}")
    await house.client.request("BREW", "/api/orders")
    await house.client.post("/api/orders", json=draft(items=[]))
    told = await scrape(house)
    count = "dray_http_request_duration_seconds_count"
    assert told[f"{count}{{method=GET,route=/api/orders/{{order}},status=200}}"] == 1
    assert told[f"{count}{{method=GET,route=/api/orders/{{order}},status=404}}"] == 1
    assert told[f"{count}{{method=GET,route=unknown,status=404}}"] == 1
    assert told[f"{count}{{method=POST,route=/api/orders,status=422}}"] == 1
    assert told[f"{count}{{method=unknown,route=unknown,status=405}}"] == 1
    assert not [series for series in told if name in series]


async def test_two_gateways_in_one_process_count_for_themselves(sqlite_url: str) -> None:
    async with gateway(sqlite_url) as one, gateway(sqlite_url) as other:
        one.bus.say(*events("M1", *AUCTION))
        assert (await scrape(one))["dray_carriers_changed_total{to=secondary}"] == 1
        assert "dray_carriers_changed_total{to=secondary}" not in await scrape(other)


async def test_names_keep_to_prometheus_conventions(house: House) -> None:
    house.bus.say(*events("M1", *AUCTION), atv_heartbeat())
    answer = await house.client.get("/metrics")
    families = [
        family for family in text_string_to_metric_families(answer.text) if family.name.startswith("dray_")
    ]
    assert len(families) > 30
    for family in families:
        assert re.fullmatch(r"dray_[a-z]+(_[a-z]+)*", family.name), family.name
        assert family.documentation.endswith("."), family.name
        assert family.type in {"counter", "gauge", "histogram"}, family.name
        assert not re.search(r"_(ms|min|minutes|percent|s)$", family.name), "base units, written out"
        # Ids have digits, and no word of ours has.
        for sample in family.samples:
            for name, value in sample.labels.items():
                assert name in {"le", "status", "route", "version"} or not re.search(r"\d", value), sample
