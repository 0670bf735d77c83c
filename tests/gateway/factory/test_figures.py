"""The factory's figures: what they are made of, kept by minutes, and over time."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from typing import Any

import pytest
from answers import problem
from gateway_kit import PRODUCT, House, gateway
from heartbeats import atv_heartbeat, events, machine_heartbeat
from wall_clock import NOW_S, Wall

from dray.gateway.factory.figure_sampler import SAMPLE_S, Sampler
from dray.gateway.factory.figures import KpiPoint, points
from dray.messages import AtvStatus, GoalBrief, MachineStatus, Pose
from dray.messages.fact import CommandObeyed, GoodsDelivered
from dray.store.factory.kpis import Kpis, KpiSample

pytestmark = pytest.mark.anyio

FIELDS = KpiSample.__struct_fields__


def sample(minute: int = 1, **fields: Any) -> KpiSample:
    """What the minute that ends after so many minutes has added: nothing, but for `fields`."""
    nothing: dict[str, Any] = dict.fromkeys(FIELDS, 0)
    nothing |= {"at_s": NOW_S // 3600 * 3600 + minute * SAMPLE_S, "span_s": SAMPLE_S}
    nothing |= {"transport_p50_s": None, "transport_p95_s": None}
    return KpiSample(**nothing | fields)


def only(samples: Sequence[KpiSample], step_s: float = 300.0) -> KpiPoint:
    [point] = points(samples, step_s)
    return point


# --- put together --------------------------------------------------------------------------------


def test_minutes_are_put_together_by_the_step_in_which_they_lie() -> None:
    begin_s = NOW_S // 3600 * 3600
    found = list(points([sample(minute, transports=1) for minute in (1, 4, 5, 6, 12)], 300.0))
    assert [(point.at_s - begin_s, point.transports) for point in found] == [(0, 3), (300, 1), (600, 1)]


def test_a_sample_that_was_written_a_moment_late_belongs_to_its_minute() -> None:
    late = sample(at_s=NOW_S // 300 * 300 + 300.2)
    assert only([late]).at_s == NOW_S // 300 * 300


def test_shares_are_of_the_sums_and_not_the_mean_of_shares() -> None:
    point = only(
        [
            sample(1, orders_delivered=9, orders_on_time=9, empty_m=10.0, loaded_m=90.0),
            sample(2, orders_delivered=1, orders_on_time=0, empty_m=5.0, loaded_m=5.0),
        ]
    )
    assert (point.orders_delivered, point.on_time_frac) == (10, 0.9)
    assert point.empty_frac == pytest.approx(15 / 110)


def test_the_parts_of_the_fleets_time_add_up_to_one() -> None:
    point = only(
        [
            sample(1, atv_moving_s=30.0, atv_waiting_s=10.0, atv_charging_s=8.0, atv_blocked_s=2.0),
            sample(2, atv_idle_s=40.0, atv_silent_s=10.0),
        ]
    )
    parts = (
        point.moving_frac,
        point.waiting_frac,
        point.charging_frac,
        point.blocked_frac,
        point.idle_frac,
        point.silent_frac,
    )
    assert parts == pytest.approx((0.3, 0.1, 0.08, 0.02, 0.4, 0.1))
    assert point.atv_available_frac == pytest.approx(0.88)


def test_a_machine_in_error_is_not_available_and_starves_only_with_a_goal() -> None:
    point = only(
        [
            sample(
                machine_making_s=40.0,
                machine_starved_s=10.0,
                machine_broken_s=10.0,
                machine_idle_s=20.0,
                machine_down_s=15.0,
                machine_silent_s=5.0,
                machine_resting_s=1000.0,
            )
        ]
    )
    assert point.starved_frac == pytest.approx(10 / 60)
    assert point.machine_available_frac == pytest.approx(0.7)


def test_of_nothing_no_share_is_told() -> None:
    point = only([sample()])
    for name in ("on_time_frac", "starved_frac", "empty_frac", "moving_frac", "atv_available_frac"):
        assert getattr(point, name) is None
    assert (point.transports_per_hour, point.commands) == (0.0, 0)


def test_quantiles_are_as_they_were_at_the_end_of_the_step() -> None:
    point = only([sample(1, transport_p50_s=80.0), sample(2, transport_p50_s=90.0, transport_p95_s=200.0)])
    assert (point.transport_p50_s, point.transport_p95_s) == (90.0, 200.0)


# --- sampled -------------------------------------------------------------------------------------


async def kept(house: House) -> list[KpiSample]:
    async with house.store.read() as work:
        return await work.kpis.between(0.0, 2 * NOW_S)


async def test_a_sample_tells_what_the_minute_has_added(house: House) -> None:
    sampler = Sampler(house.projection, house.store, house.wall)
    goals = (GoalBrief(goal="G1", product=PRODUCT, quantity=4, made=0, delivered=0),)
    for at_s, x_m in ((0.0, 0.0), (10.0, 8.0)):
        house.bus.say(
            atv_heartbeat(
                seq=int(at_s) + 1,
                at_s=at_s,
                pose=Pose(x_m, 0.0, 0.0),
                status=AtvStatus.WORKING,
                speed_mps=1.0,
            ),
            machine_heartbeat(seq=int(at_s) + 1, at_s=at_s, status=MachineStatus.STARVED, goals=goals),
        )
    house.bus.say(*events("ATV1", CommandObeyed(command="c", what="stop", done=True)))
    house.wall.now_s += 20.0
    await sampler.sample()
    [first] = await kept(house)
    assert (first.at_s, first.span_s, first.empty_m, first.commands) == (NOW_S + 20.0, 20.0, 8.0, 1)
    assert (first.atv_moving_s, first.machine_starved_s) == (20.0, 20.0)
    house.wall.now_s += 20.0
    await sampler.sample()
    [_, second] = await kept(house)
    assert (second.empty_m, second.commands) == (0.0, 0)
    assert (second.atv_moving_s, second.atv_silent_s) == (5.0, 15.0)


async def test_what_cannot_be_written_is_in_the_next_sample(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    sampler = Sampler(house.projection, house.store, house.wall)

    async def fail(_kpis: Kpis, _sample: Any) -> None:
        raise ConnectionRefusedError

    house.wall.now_s += 60.0
    with monkeypatch.context() as patch:
        patch.setattr(Kpis, "add", fail)
        await sampler.sample()
    assert await kept(house) == []
    house.wall.now_s += 60.0
    await sampler.sample()
    assert [one.span_s for one in await kept(house)] == [120.0]


async def test_the_oldest_samples_are_forgotten(house: House) -> None:
    async with house.store.write() as work:
        for age_s in (3.0, 2.0, 1.0):
            await work.kpis.add(sample(at_s=NOW_S - age_s))
        assert [await work.kpis.prune(NOW_S - 1.0, 1) for _ in range(3)] == [1, 1, 0]
    assert [one.at_s for one in await kept(house)] == [NOW_S - 1.0]


async def test_a_gateway_that_ends_keeps_the_minute_that_has_begun(url: str) -> None:
    wall = Wall()
    async with gateway(url, wall=wall) as house:
        order = (await house.place())["id"]
        arrived = GoodsDelivered(goal="G1", order=order, item=0, product=PRODUCT, quantity=5, delivered=5)
        await house.say(events("M1", arrived))
        wall.now_s += 30.0
    async with gateway(url, wall=wall, incarnation=2) as house:
        [point] = (await house.get("/api/kpis/history"))["items"]
        assert (point["orders_delivered"], point["on_time_frac"], point["span_s"]) == (1, 1.0, 30.0)


# --- shown ---------------------------------------------------------------------------------------


async def test_the_figures_of_now_tell_what_the_fleet_does(house: House) -> None:
    before = await house.get("/api/kpis")
    assert (before["use"], before["empty_frac"], before["atv_available_frac"]) == (None, None, None)
    for seq, status in enumerate((AtvStatus.CHARGING, AtvStatus.STOPPED, AtvStatus.STOPPED), 1):
        house.bus.say(atv_heartbeat(seq=seq, at_s=10.0 * seq, status=status))
    figures = await house.get("/api/kpis")
    assert figures["use"] == {
        "moving": 0.0,
        "waiting": 0.0,
        "charging": 0.5,
        "blocked": 0.5,
        "idle": 0.0,
        "silent": 0.0,
        "out_of_service": 0.0,
    }
    assert figures["atv_available_frac"] == 0.5


async def test_the_history_is_of_the_last_eight_hours_in_steps_of_five_minutes(house: House) -> None:
    async with house.store.write() as work:
        for ago_s in (9 * 3600.0, 3600.0, 3540.0, 60.0):
            await work.kpis.add(sample(at_s=NOW_S - ago_s, transports=1))
    history = await house.get("/api/kpis/history")
    assert history["step_s"] == 300.0
    assert history["since_at_s"] == (NOW_S - 8 * 3600.0) // 300 * 300
    assert sum(point["transports"] for point in history["items"]) == 3
    assert all(point["at_s"] % 300 == 0 for point in history["items"])


async def test_the_history_comes_as_a_table_too(house: House) -> None:
    async with house.store.write() as work:
        await work.kpis.add(sample(at_s=1_899_999_990.0, transports=3, empty_m=1.0, loaded_m=2.0))
    params = {"since": "2030-03-17T17:00:00Z", "until": "2030-03-17T18:00:00Z", "step": 60, "format": "csv"}
    response = await house.client.get("/api/kpis/history", params=params)
    assert response.headers["content-type"] == "text/csv; charset=utf-8"
    [row] = csv.DictReader(io.StringIO(response.text))
    assert (row["at"], row["transports"], row["empty_frac"]) == ("2030-03-17T17:46:00.000Z", "3", "0.3333")
    assert row["on_time_frac"] == ""


@pytest.mark.parametrize(
    ("params", "field"),
    [
        ({"since": "2030-03-17T18:00:00Z", "until": "2030-03-17T17:00:00Z"}, "until"),
        ({"since": "2029-01-01T00:00:00Z"}, "since"),
        ({"since": "2030-03-10T00:00:00Z", "step": "60"}, "step"),
        ({"step": "61"}, "step"),
        ({"since": "yesterday"}, "since"),
    ],
)
async def test_a_history_that_cannot_be_told_is_refused(
    house: House, params: dict[str, str], field: str
) -> None:
    answer = await house.client.get("/api/kpis/history", params=params)
    body = problem(answer, 422, "unusable-fields")
    assert [error["field"] for error in body["errors"]] == [field]
