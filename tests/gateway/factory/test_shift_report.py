"""The report on a shift: read from SQL, against the shift before and against targets."""

from __future__ import annotations

import csv
import io
from datetime import UTC, datetime
from itertools import pairwise
from typing import Any

import pytest
from answers import problem
from gateway_kit import PRODUCT, House, gateway
from heartbeats import atv_heartbeat, events
from wall_clock import NOW_S, Wall

from dray.gateway.access.principal import Role, Scope
from dray.gateway.factory.shift_report import FIGURES
from dray.gateway.live.replay.spells import LONGEST_S
from dray.messages import AtvStatus, Reason
from dray.messages.fact import CarrierChanged
from dray.shift_times import shifts_of
from dray.store.factory.kpis import KpiSample
from dray.store.factory.lane_traffic import LaneTraffic
from dray.store.orders.orders import Item, Order
from dray.store.orders.progress import OrderStatus
from dray.store.orders.tasks import TaskRow
from dray.store.replay.spells import Spell
from dray.store.retention import KeptFor, Retention

pytestmark = pytest.mark.anyio

HOUR_S, DAY_S = 3600.0, 86_400.0
BEGIN_S = NOW_S - 8 * HOUR_S


def at(wall_s: float) -> str:
    return datetime.fromtimestamp(wall_s, UTC).isoformat()


SHIFT = {"from": at(BEGIN_S), "until": at(NOW_S)}


def sample(at_s: float, **fields: Any) -> KpiSample:
    nothing: dict[str, Any] = dict.fromkeys(KpiSample.__struct_fields__, 0)
    nothing |= {"at_s": at_s, "span_s": 60.0, "transport_p50_s": None, "transport_p95_s": None}
    return KpiSample(**nothing | fields)


def spell(agent: str, doing: str, from_s: float, until_s: float, **fields: Any) -> Spell:
    return Spell(agent=agent, doing=doing, from_at_s=from_s, until_at_s=until_s, **fields)


def order(name: str, **fields: Any) -> Order:
    usual: dict[str, Any] = {
        "status": OrderStatus.DELIVERED,
        "customer": "Muster GmbH",
        "token": name,
        "items": (Item(PRODUCT, 5),),
        "created_at_s": BEGIN_S - DAY_S,
        "released_at_s": BEGIN_S - DAY_S,
    }
    usual |= fields
    usual.setdefault("updated_at_s", usual.get("delivered_at_s") or NOW_S)
    return Order(id=name, **usual)


async def report(house: House, **asked: str) -> tuple[dict[str, Any], dict[str, dict[str, Any]]]:
    """The report, and its figures by name."""
    told = await house.get("/api/reports/shift", **SHIFT | asked)
    return told, {each["name"]: each for each in told["figures"]}


async def test_of_a_shift_of_which_nothing_is_kept_no_figure_is_invented(house: House) -> None:
    told, figures = await report(house)
    assert list(figures) == list(FIGURES)
    # Orders and people's acts are kept for good: of these nothing is none.
    known = {name for name, each in figures.items() if each["value"] is not None}
    assert known == {"orders_delivered", "orders_late", "orders_open", "orders_overdue", "interventions"}
    assert told["period"]["seen_frac"] == 0.0
    # But where nobody has counted there is nothing to compare with.
    assert {each["before"] for each in figures.values()} == {None}


async def test_a_shift_is_compared_with_what_was_counted_in_the_other_a_count_of_none_included(
    house: House,
) -> None:
    async with house.store.write() as work:
        await work.orders.add_all([order("O-1", delivered_at_s=NOW_S - DAY_S - 60)])
    _, figures = await report(house)
    # An order that was delivered is known, though nobody has counted minutes.
    assert (figures["orders_delivered"]["before"], figures["orders_late"]["before"]) == (1, None)
    async with house.store.write() as work:
        await work.kpis.add(sample(NOW_S - DAY_S - HOUR_S))
    _, figures = await report(house)
    assert (figures["orders_delivered"]["before"], figures["orders_late"]["before"]) == (1, 0)


async def test_orders_count_in_the_shift_in_which_they_came_and_open_ones_at_its_end(house: House) -> None:
    async with house.store.write() as work:
        await work.orders.add_all(
            [
                order("O-1", delivered_at_s=BEGIN_S, due_at_s=BEGIN_S),
                order("O-2", delivered_at_s=NOW_S - 60, due_at_s=NOW_S - 120, reference="PO-2"),
                order(
                    "O-3", delivered_at_s=NOW_S, due_at_s=NOW_S - HOUR_S
                ),  # Delivered in the next shift: open, and overdue.
                order("O-4", delivered_at_s=BEGIN_S - 1),
                order("O-5", status=OrderStatus.RELEASED, due_at_s=NOW_S + 60),
                order("O-6", status=OrderStatus.STORED, released_at_s=None),
                order("O-7", status=OrderStatus.CANCELLED, cancelled_at_s=NOW_S - 60),
                order("O-8", status=OrderStatus.CANCELLED, cancelled_at_s=NOW_S + 60),  # Open at the end.
            ]
        )
    house.wall.now_s += HOUR_S
    told, figures = await report(house)
    found = {name: figures[f"orders_{name}"]["value"] for name in ("delivered", "late", "open", "overdue")}
    assert found == {"delivered": 2, "late": 1, "open": 3, "overdue": 1}
    assert figures["on_time_frac"]["value"] == 0.5
    late = [(each["id"], each["reference"], each["delivered_at_s"]) for each in told["late_orders"]]
    assert late == [("O-3", None, None), ("O-2", "PO-2", NOW_S - 60)]


async def test_minutes_are_summed_and_set_against_the_day_before_the_time_before_and_a_week_before(
    house: House,
) -> None:
    async with house.store.write() as work:
        for at_s, transports in ((NOW_S, 7), (NOW_S - DAY_S, 5), (BEGIN_S, 3), (NOW_S - 7 * DAY_S, 2)):
            await work.kpis.add(
                sample(
                    at_s,
                    transports=transports,
                    energy_wh=35.0,
                    machine_making_s=45.0,
                    machine_starved_s=15.0,
                    machine_idle_s=30.0,
                )
            )
    for against, before in (("day", 5), ("before", 3), ("week", 2)):
        told, figures = await report(house, against=against)
        assert (figures["transports"]["value"], figures["transports"]["before"]) == (7, before)
    assert figures["starved_frac"]["value"] == 0.25
    assert figures["machine_producing_frac"]["value"] == 0.75
    assert (figures["energy_wh"]["value"], figures["transport_energy_wh"]["value"]) == (35.0, 5.0)
    assert [point["transports"] for point in told["course"]] == [7]
    assert told["period"]["seen_frac"] == pytest.approx(60 / (8 * HOUR_S))


async def test_transport_times_are_of_what_was_handed_over_in_the_shift_by_the_factorys_clock(
    url: str,
) -> None:
    def task(name: str, closed_at_s: float, took_s: float, **fields: Any) -> TaskRow:
        times = {
            "opened_at_s": closed_at_s - took_s,
            "closed_at_s": closed_at_s,
            "deadline_at_s": closed_at_s,
        }
        usual: dict[str, Any] = {"kind": "transport", "coordinator": "M1", "item": PRODUCT, "quantity": 1}
        return TaskRow(id=name, **usual | {"state": "delivered"} | times | fields)

    async with gateway(url, speed=2.0) as house:
        async with house.store.write() as work:
            await work.tasks._put(
                [
                    *(task(f"T-{took}", BEGIN_S + 10 * took, float(took)) for took in range(1, 21)),
                    task("T-before", BEGIN_S - 1, 500.0),
                    task("T-after", NOW_S, 500.0),
                    task("T-old", BEGIN_S + 5, 2 * DAY_S),
                    task("T-off", BEGIN_S + 60, 500.0, state="withdrawn"),
                    task("T-goal", BEGIN_S + 60, 500.0, kind="production"),
                ]
            )
        _, figures = await report(house)
        assert figures["transport_p50_s"]["value"] == pytest.approx(20.0)
        assert figures["transport_p95_s"]["value"] == pytest.approx(38.0)


async def test_spells_are_cut_at_the_ends_of_the_shift_and_told_by_vehicle_machine_and_area(
    house: House,
) -> None:
    async with house.store.write() as work:
        await work.spells.add(
            [
                spell("ATV1", "carries", BEGIN_S - 100, BEGIN_S + 300),
                spell("ATV1", "waits", BEGIN_S + 300, BEGIN_S + 400, other="ATV2"),
                spell("ATV1", "waits", NOW_S - 10, NOW_S + 500, other="ATV3"),
                spell("ATV2", "idle", BEGIN_S - 900, BEGIN_S),
                spell("M1", "makes", BEGIN_S, BEGIN_S + 60),
                spell("M1", "starves", BEGIN_S + 60, BEGIN_S + 80, other="steel"),
            ]
        )
        area = next(iter(house.projection.site.plant.areas.values()))
        extent = house.projection.site.plant.extent_of(area.id)
        start = min(extent.nodes)
        await work.lane_hours.add(BEGIN_S + HOUR_S, [LaneTraffic(start, "elsewhere", 9, 4, 33.0)])
    house.wall.now_s += HOUR_S
    told, figures = await report(house)
    agents = {each["agent"]: each for each in told["agents"]}
    assert agents["ATV1"]["doings_s"] == {"carries": 300.0, "waits": 110.0}
    assert (agents["ATV1"]["kind"], agents["M1"]["kind"]) == ("atv", "machine")
    assert "ATV2" not in agents
    assert (figures["waits"]["value"], figures["waited_frac"]["value"]) == (2, pytest.approx(110 / 410))
    assert [(each["agent"], each["other"]) for each in told["waits"]] == [("ATV1", "ATV3"), ("ATV1", "ATV2")]
    areas = {each["area"]: each for each in told["areas"]}
    assert (areas[area.id]["passes"], areas[area.id]["waits"], areas[area.id]["waited_s"]) == (9, 4, 33.0)
    [where] = [areas[each] for each in agents["M1"]["areas"]]
    assert where["starved_frac"] == 0.25


async def test_what_lasts_for_hours_is_in_sql_hour_by_hour(house: House) -> None:
    for seq in range(1, 4):
        house.wall.now_s += LONGEST_S * 0.8
        house.bus.say(atv_heartbeat(seq=seq, at_s=house.wall.now_s - NOW_S, status=AtvStatus.CHARGING))
        house.hub.tick()
    await house.recorder.write()
    async with house.store.read() as work:
        kept = await work.spells.between(0.0, 2 * NOW_S, ("ATV1",), 10)
    assert kept
    assert all(each.until_at_s - each.from_at_s <= LONGEST_S for each in kept)
    assert all(later.from_at_s == earlier.until_at_s for earlier, later in pairwise(kept))
    # What goes on is in the report of a shift that goes on, as far as it has come.
    told, _ = await report(house, **{"from": at(NOW_S), "until": at(house.wall.now_s + HOUR_S)})
    [agent] = [each for each in told["agents"] if each["agent"] == "ATV1"]
    assert sum(agent["doings_s"].values()) == pytest.approx(LONGEST_S * 1.6, abs=1.0)
    assert told["period"]["until_at_s"] == house.wall.now_s


async def test_takeovers_and_what_people_did_are_told_with_cause_and_role_and_without_names(
    house: House,
) -> None:
    house.wall.now_s += 200.0
    changed = CarrierChanged("M1-1", 2, "ATV3", "ATV1", Reason.SILENT, 4.0)
    nobody = CarrierChanged("M1-2", 2, "ATV3", "", Reason.SILENT, 4.0)
    await house.say(events("M1", changed, nobody))
    mia = await house.log_in("mia")
    body = {"reason": "a visitor", "kind": "closed", "place": "M1"}
    answer = await mia.post("/api/closures", json=body)
    assert answer.status_code < 300, answer.text
    await house.access.audit_log.catch_up()
    house.wall.now_s += 60.0
    told, figures = await report(house, until=at(house.wall.now_s))
    [taken] = told["takeovers"]
    assert (taken["replaced"], taken["carrier"], taken["reason"]) == ("ATV3", "ATV1", "silent")
    assert figures["takeovers"]["value"] == 1
    [act] = told["interventions"]
    assert (act["action"], act["role"]) == ("floor.close", "manager")
    assert "mia" not in str(told).lower()
    assert figures["interventions"]["value"] == 1
    # Who may not read the log, or orders, is told how many and not which.
    _, header = await house.key(Scope.FACTORY_READ)
    less = (
        await house.visitor(**header).get(
            "/api/reports/shift", params=SHIFT | {"until": at(house.wall.now_s)}
        )
    ).json()
    assert (less["interventions"], less["late_orders"]) == ([], [])
    assert {each["name"]: each["value"] for each in less["figures"]}["interventions"] == 1


async def test_takeovers_are_told_when_the_log_of_events_has_forgotten_them(house: House) -> None:
    house.wall.now_s += 200.0
    changed = CarrierChanged("M1-1", 2, "ATV3", "ATV1", Reason.SILENT, 4.0)
    await house.say(events("M1", changed))
    before, _ = await report(house, until=at(house.wall.now_s + 1.0))
    forgotten = KeptFor(
        events_s=-1e9,
        samples_s=0,
        figures_s=1e9,
        tasks_s=0,
        transports_s=0,
        alerts_s=0,
        audit_s=1e9,
        events_most=1000,
    )
    await Retention(house.store, forgotten, house.wall).forget()
    assert (await house.get("/api/events"))["items"] == []
    after, figures = await report(house, until=at(house.wall.now_s + 1.0))
    assert figures["takeovers"]["value"] == 1
    assert after["takeovers"] == before["takeovers"] != []


async def test_targets_are_set_by_a_manager_kept_and_written_into_the_log(url: str) -> None:
    async with gateway(url) as house:
        assert (await house.get("/api/reports/targets"))["targets"] == {}
        mia = await house.log_in("mia")
        answer = await mia.put(
            "/api/reports/targets", json={"targets": {"transports": 8, "starved_frac": 0.3}}
        )
        assert answer.status_code == 200, answer.text
        answer = await mia.put("/api/reports/targets", json={"targets": {"transports": 8, "helps": 2}})
        assert answer.json()["by"] == "Mia"
        async with house.store.write() as work:
            await work.kpis.add(sample(NOW_S, transports=7, helps=2))
        lines = await house.audit(action="report.targets")
        assert [line.who for line in lines] == ["mia", "mia"]
        _, figures = await report(house)
        assert (figures["transports"]["target"], figures["transports"]["missed"]) == (8, True)
        assert (figures["helps"]["target"], figures["helps"]["missed"]) == (2, False)
        assert figures["starved_frac"]["target"] is None
        otto = await house.log_in("otto", Role.OPERATOR, "area1")
        assert (await otto.put("/api/reports/targets", json={"targets": {}})).status_code == 403
    async with gateway(url, incarnation=2, wall=Wall()) as house:
        assert (await house.get("/api/reports/targets"))["targets"] == {"transports": 8, "helps": 2}


@pytest.mark.parametrize(
    ("targets", "field"),
    [
        ({"speed": 1}, "targets.speed"),
        ({"on_time_frac": 95}, "targets.on_time_frac"),
        ({"helps": -1}, "targets.helps"),
        ({"helps": "many"}, "targets.helps"),
    ],
)
async def test_a_target_that_makes_no_sense_is_refused_and_the_others_stay(
    house: House, targets: dict[str, Any], field: str
) -> None:
    await house.client.put("/api/reports/targets", json={"targets": {"helps": 2}})
    answer = await house.client.put("/api/reports/targets", json={"targets": targets})
    assert problem(answer, 422, "unusable-fields")["errors"][0]["field"] == field
    assert (await house.get("/api/reports/targets"))["targets"] == {"helps": 2}


async def test_a_time_that_is_none_or_too_long_is_refused(house: House) -> None:
    for since_s, until_s in ((NOW_S, NOW_S), (NOW_S - 8 * DAY_S, NOW_S), (NOW_S + 60, NOW_S + 120)):
        asked = {"from": at(since_s), "until": at(until_s)}
        problem(await house.client.get("/api/reports/shift", params=asked), 422, "unusable-fields")


async def test_the_table_has_every_figure_and_what_each_did(house: House) -> None:
    async with house.store.write() as work:
        await work.spells.add([spell("ATV1", "waits", BEGIN_S, BEGIN_S + 100, other="=ATV2")])
    answer = await house.client.get("/api/reports/shift", params=SHIFT | {"format": "csv"})
    rows = list(csv.DictReader(io.StringIO(answer.text)))
    assert [row["figure"] for row in rows if row["part"] == "figures"] == list(FIGURES)
    assert [row["value"] for row in rows if (row["name"], row["figure"]) == ("ATV1", "waits")] == ["100.0"]
    [wait] = [row for row in rows if row["part"] == "wait"]
    assert wait["figure"] == "'=ATV2"


async def test_energy_is_what_batteries_lose_and_a_gauge_that_wanders_loses_nothing_twice(
    house: House,
) -> None:
    battery_wh = house.projection.site.plant.vehicle_types[
        house.projection.site.plant.fleet["ATV1"].type
    ].battery_wh
    for seq, (battery_frac, status) in enumerate(
        [
            (0.80, AtvStatus.WORKING),
            (0.79, AtvStatus.WORKING),
            (0.80, AtvStatus.WORKING),
            (0.78, AtvStatus.WORKING),
            (0.90, AtvStatus.CHARGING),
            (0.89, AtvStatus.WORKING),
        ],
        1,
    ):
        house.bus.say(atv_heartbeat(seq=seq, battery_frac=battery_frac, status=status))
    assert house.projection.totals(house.wall.now_s).energy_wh == pytest.approx(0.03 * battery_wh)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "early",
        "early 6:00",
        "early 24:00",
        "late 14:00, early 06:00",
        "a 06:00, a 14:00",
        "a 06:00,, b 07:00",
    ],
)
def test_shifts_that_nobody_can_read_are_refused(text: str) -> None:
    with pytest.raises(ValueError, match="early 06:00"):
        shifts_of(text)


def test_shifts_are_read_as_people_write_them() -> None:
    assert shifts_of("Früh 05:30, Spät 13:30") == (("Früh", 330), ("Spät", 810))
