"""A plain transport's page for others: made, told and taken back as an order's, and nothing of the plant but what was asked."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Any

import pytest
from answers import problem
from gateway_kit import House
from heartbeats import events
from tracking_kit import GERMAN, assert_private
from wall_clock import NOW_S

from dray.gateway.access.principal import Scope
from dray.gateway.http.provided import provided
from dray.gateway.live.projection import Projection
from dray.gateway.tracking.facts import KEPT_S
from dray.gateway.tracking.texts import TEXTS
from dray.messages import Phase, Reason, Transport, TransportState
from dray.messages import Role as Part
from dray.messages.fact import (
    AwardAnswered,
    CarrierChanged,
    PhaseEntered,
    TaskClosed,
    TaskOpened,
    TransportProgressed,
)
from dray.store.orders.tracking_links import WORKING_MAX

pytestmark = pytest.mark.anyio

PATH = "/api/transports"
DRAFT = {"from": "S3", "to": "M8", "item": "shaft", "quantity": 40}


async def called(house: House, **fields: Any) -> str:
    response = await house.client.post(PATH, json=DRAFT | fields)
    assert response.status_code == 201, response.text
    return str(response.json()["id"])


async def linked(house: House, name: str, **fields: Any) -> str:
    """The token of a new link."""
    response = await house.client.post(f"{PATH}/{name}/links", json=fields)
    assert response.status_code == 201, response.text
    return str(response.json()["tracking_url"]).rpartition("/track/")[2]


async def page(house: House, token: str, status: int = 200, **headers: str) -> str:
    response = await house.visitor(**headers).get(f"/track/{token}")
    assert response.status_code == status, response.text
    assert_private(response.headers)
    return response.text


async def told(house: House, token: str) -> dict[str, Any]:
    response = await house.visitor().get(f"/api/track/transports/{token}")
    assert response.status_code == 200, response.text
    answer: dict[str, Any] = response.json()
    return answer


async def progress(house: House, name: str, number: int, state: TransportState, **fields: Any) -> None:
    fact = TransportProgressed(name, state, "shaft", 40, "S3", "M8", **fields)
    await house.say(events("M8", fact, first=number))


async def test_its_page_tells_what_from_where_to_where_how_far_and_when(house: House) -> None:
    name = await called(house)
    token = await linked(house, name)
    shaft = provided(house.app, Projection).site.plant.materials["shaft"].name
    text = await page(house, token)
    assert "Transport from S3 to M8" in text
    assert "Transport tracking" in text
    assert "Order" not in text
    assert TEXTS["en"].one_part.format(quantity=40, name=shaft) in text
    assert TEXTS["en"].cannot_say in text
    assert "Transport von S3 nach M8" in await page(house, token, **GERMAN)
    await progress(house, name, 1, TransportState.WAITING, wait="short")
    assert TEXTS["en"].transport_why["short"] in await page(house, token)
    await progress(house, name, 2, TransportState.ASSIGNED, carrier="ATV6", expected_s=90.0, task=f"{name}-1")
    text, answer = await page(house, token), await told(house, token)
    # The carrier and its task are the plant's own matter.
    assert "ATV6" not in text
    assert "ATV6" not in str(answer)
    assert name not in text
    assert (answer["status"], answer["from"], answer["to"], answer["name"]) == ("assigned", "S3", "M8", shaft)
    expected = datetime.fromisoformat(answer["expected_at"]).timestamp()
    assert expected == pytest.approx(NOW_S + 90.0, abs=1.0)
    await progress(house, name, 3, TransportState.DELIVERED)
    text, answer = await page(house, token), await told(house, token)
    assert "data-ended" in text
    assert (answer["status"], answer["expected_at"], answer["late"]) == ("delivered", None, False)


async def test_each_step_that_has_happened_has_its_time(house: House) -> None:
    name = await called(house)
    token, task, work = await linked(house, name), f"{name}-1", Transport("shaft", 40, ("S3",), "M8", "tote")

    def progressed(state: TransportState) -> TransportProgressed:
        return TransportProgressed(name, state, "shaft", 40, "S3", "M8", task=task)

    number = 0

    async def steps(*told_by: tuple[str, Any]) -> list[float | None]:
        nonlocal number
        for agent, fact in told_by:
            number += 1
            await house.say(events(agent, fact, first=number, at_s=9.0 * number))
        answer = await told(house, token)
        text = await page(house, token)
        assert text.count("<time") == 1 + sum(
            answer[at] is not None for at in ("assigned_at", "on_board_at", "ended_at")
        )
        return [
            None if at is None else round(datetime.fromisoformat(at).timestamp() - NOW_S)
            for at in (answer["assigned_at"], answer["on_board_at"])
        ]

    assert await steps() == [None, None]
    opened = TaskOpened(task, 1, Part.PRIMARY, 1, work, 20.0, 300.0, 5.0)
    begun = await steps(
        ("M8", opened),
        ("M8", AwardAnswered(task, 1, Part.PRIMARY, "ATV6", "accepted")),
        ("ATV6", PhaseEntered(task, 1, Phase.APPROACHING, "S3")),
        ("M8", progressed(TransportState.ASSIGNED)),
    )
    [set_off_s, _] = begun
    assert set_off_s is not None
    assert begun == [set_off_s, None]
    # Another vehicle goes on: it has been fetched since the first set off.
    carried = await steps(
        ("M8", CarrierChanged(task, 2, "ATV6", "ATV1", Reason.SILENT, 5.5)),
        ("ATV1", PhaseEntered(task, 2, Phase.APPROACHING, "S3")),
        ("ATV1", PhaseEntered(task, 2, Phase.CARRYING, "S3")),
        ("M8", progressed(TransportState.ON_BOARD)),
    )
    # Ten seconds apart: an event is told a second later with each number.
    assert carried == [set_off_s, set_off_s + 40]
    assert (
        await steps(
            ("M8", TaskClosed(task, 2, "delivered", "ATV1", 45.0)),
            ("M8", progressed(TransportState.DELIVERED)),
        )
        == carried
    )


async def test_one_that_is_not_to_begin_yet_says_when_it_does(house: House) -> None:
    at_s = NOW_S + 3600.0
    token = await linked(house, await called(house, not_before=datetime.fromtimestamp(at_s, UTC).isoformat()))
    text = await page(house, token)
    assert TEXTS["en"].not_started in text
    assert "Begins today" in text
    assert (await told(house, token))["wait"] == "not_before"


async def test_it_is_late_once_its_time_has_passed(house: House) -> None:
    name = await called(house)
    token = await linked(house, name)
    assert not (await told(house, token))["late"]
    house.wall.now_s += 1000.0
    assert (await told(house, token))["late"]
    assert TEXTS["en"].late_yes in await page(house, token)


async def test_links_are_told_without_their_address_and_taken_back_together(house: House) -> None:
    name = await called(house)
    first, second = await linked(house, name), await linked(house, name, days=30)
    links = (await house.get(f"{PATH}/{name}/timeline"))["links"]
    assert [each["expires_at_s"] for each in links].count(None) == 1
    assert first not in str(links)
    assert (await house.client.delete(f"{PATH}/{name}/links")).json() == {"count": 2}
    for token in (first, second):
        await page(house, token, 410)
        problem(await house.visitor().get(f"/api/track/transports/{token}"), 410, "tracking-link-ended")
    assert [line.action for line in (await house.audit())[:3]] == [
        "link.revoke",
        "link.create",
        "link.create",
    ]


async def test_a_link_ends_a_quarter_after_the_transport_or_when_it_was_said(house: House) -> None:
    name = await called(house)
    forever, short = await linked(house, name), await linked(house, name, days=1)
    house.wall.now_s += 86_400.0
    await page(house, short, 410)
    await page(house, forever)
    await progress(house, name, 1, TransportState.DELIVERED)
    ended_at = (await told(house, forever))["ended_at"]
    house.wall.now_s = datetime.fromisoformat(ended_at).timestamp() + KEPT_S + 1.0
    await page(house, forever, 410)


async def test_an_orders_link_opens_no_transport_and_the_other_way_round(house: House) -> None:
    order = await house.place()
    of_order = order["tracking_url"].rpartition("/")[2]
    of_transport = await linked(house, await called(house))
    problem(await house.visitor().get(f"/api/track/transports/{of_order}"), 404, "unknown-tracking-page")
    problem(await house.visitor().get(f"/api/track/{of_transport}"), 404, "unknown-tracking-page")
    await page(house, "nothing-of-this-name", 404)


async def test_as_many_links_lead_there_as_may_be(house: House) -> None:
    name = await called(house)
    for _ in range(WORKING_MAX):
        await linked(house, name)
    full = await house.client.post(f"{PATH}/{name}/links", json={})
    problem(full, 409, "too-many-links")


async def test_a_call_button_makes_none_and_nobody_for_what_is_not_there(house: House) -> None:
    name = await called(house)
    _, header = await house.key(Scope.TRANSPORTS_CALL)
    assert (await house.visitor(**header).post(f"{PATH}/{name}/links", json={})).status_code == 403
    missing = await house.client.post(f"{PATH}/T-none/links", json={})
    problem(missing, 404, "unknown-transport")
    problem(await house.client.delete(f"{PATH}/T-none/links"), 404, "unknown-transport")
