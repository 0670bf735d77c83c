"""The customer's page: every state of an order, what makes it late, and who reads it."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from fake_bus import PLANT
from gateway_kit import OTHER_PRODUCT, PRODUCT, House, gateway
from heartbeats import machine_heartbeat
from tracking_kit import (
    GERMAN,
    GOAL,
    MACHINE,
    OTHER_MACHINE,
    PACE_S,
    WAY_OUT,
    Story,
    assert_private,
    iso,
)
from wall_clock import NOW_S

from dray.gateway.http.assets import Panels
from dray.messages import GoalBrief, MachineHeartbeat, MaterialWait, Reason
from dray.messages.fact import PromiseMoved
from dray.messages.heartbeat import MachineStatus, TaskBrief

pytestmark = pytest.mark.anyio

STAGES = ["placed", "planned", "in_production", "on_its_way", "delivered"]


def reached(state: dict[str, Any]) -> list[str]:
    return [stage["name"] for stage in state["stages"] if stage["reached"]]


def times(state: dict[str, Any]) -> list[str | None]:
    return [stage["at"] and stage["at"][11:19] for stage in state["stages"]]


# --- the way of an order ----------------------------------------------------------------------------


async def test_an_order_that_was_placed_waits_to_be_planned_and_nothing_is_promised(house: House) -> None:
    story = await Story.begin(house, reference="4711")
    state = await story.state()
    assert reached(state) == ["placed"]
    assert (state["eta"], state["reasons"], state["late"]) == (None, [], "")
    page = await story.page()
    assert "Order 4711" in page
    assert "40 × Gear unit G1" in page  # noqa: RUF001
    assert "Cannot be said yet" in page


async def test_a_planned_order_is_expected_when_its_machine_has_promised(house: House) -> None:
    story = await Story.begin(house)
    await story.planned(finish_s=700.0)
    story.now(100.0)
    # Another goal comes first.
    story.beat(MACHINE, 100.0, goal="strategist.1-1")
    state = await story.state()
    assert reached(state) == ["placed", "planned"]
    assert times(state)[:2] == ["17:46:40", "17:48:20"]
    assert state["eta"] == {"earliest": "2030-03-17T17:58:00Z", "latest": "2030-03-17T18:04:00Z"}


async def test_an_order_in_production_tells_how_many_and_by_their_pace_when(house: House) -> None:
    story = await Story.begin(house)
    await story.planned()
    now_s = await story.making(26)
    state = await story.state()
    assert reached(state) == ["placed", "planned", "in_production"]
    assert times(state)[2] == "17:48:40"
    assert state["items"] == [
        {"product": PRODUCT, "name": "Gear unit G1", "quantity": 40, "made": 26, "delivered": 0}
    ]
    last_piece_at = NOW_S + now_s + 14 * PACE_S
    assert state["eta"]["earliest"] <= iso(last_piece_at) <= state["eta"]["latest"]
    page = await story.page()
    assert "26 of 40 made" in page
    assert '<progress aria-label="Made: Gear unit G1" max="40" value="26">' in page
    assert re.search(r'<li class="now" aria-current="step">\s*<span class="name">In production', page)


async def test_an_order_whose_machine_has_begun_is_in_production_before_its_first_piece(house: House) -> None:
    story = await Story.begin(house)
    await story.planned()
    assert reached(await story.state()) == ["placed", "planned", "in_production"]
    assert "0 of 40 made" in await story.page()


async def test_an_order_on_its_way_tells_how_much_has_arrived(house: House) -> None:
    story = await Story.begin(house)
    await story.planned()
    await story.making(40)
    await story.leaving(520.0)
    assert reached(await story.state()) == STAGES[:4]
    assert times(await story.state())[3] == "17:55:20"
    await story.arrived(20, 560.0)
    assert (await story.state())["items"][0]["delivered"] == 20
    assert "20 of 40 delivered" in await story.page()


async def test_an_order_is_being_delivered_for_its_customer_when_its_status_says_so(house: House) -> None:
    story = await Story.begin(house)
    await story.planned()
    await story.making(20)
    # Of two loads one has left: more is being made, and nothing is there yet.
    await story.leaving(320.0)
    state = await story.state()
    assert (state["status"], reached(state)) == ("in_production", STAGES[:3])
    await story.arrived(4, 400.0)
    state = await story.state()
    assert (state["status"], reached(state)) == ("in_delivery", STAGES[:4])
    assert times(state)[3] == "17:52:00"
    page = await story.page()
    assert re.search(r'<li class="now" aria-current="step">\s*<span class="name">Being delivered', page)


async def test_an_order_of_which_all_is_made_is_being_delivered_before_a_vehicle_has_fetched_it(
    house: House,
) -> None:
    story = await Story.begin(house)
    await story.planned()
    await story.making(40)
    state = await story.state()
    assert (state["status"], reached(state)) == ("in_delivery", STAGES[:4])
    assert times(state)[3] is None


async def test_a_delivered_order_says_when_and_asks_for_no_more_news(house: House) -> None:
    story = await Story.begin(house, due_at="2030-03-17T18:46:40Z")
    await story.planned()
    await story.making(40)
    assert "data-ended" not in await story.page()
    await story.arrived(40, 600.0)
    state = await story.state()
    assert reached(state) == STAGES
    assert (state["status"], state["late"], state["eta"]) == ("delivered", "", None)
    assert state["delivered_at"] == "2030-03-17T17:56:40Z"
    page = await story.page()
    assert "data-ended" in page
    assert "Today, 17:56" in page


async def test_an_order_of_several_parts_shows_each_of_them(house: House) -> None:
    order = await house.place(
        items=[{"product": PRODUCT, "quantity": 1200}, {"product": OTHER_PRODUCT, "quantity": 5}]
    )
    page = await Story(house, order).page()
    assert "2 products, 1,205 pieces" in page
    assert page.count("<progress ") == 4


async def test_a_stored_order_says_that_nobody_has_asked_to_begin(house: House) -> None:
    story = await Story.begin(house, release=False)
    assert (await story.state())["reasons"] == ["not_released"]
    assert "Production has not been asked to begin." in await story.page()


async def test_a_cancelled_order_says_so_and_how_far_it_came(house: House) -> None:
    story = await Story.begin(house)
    await story.planned()
    await story.making(12)
    await house.client.post(f"/api/orders/{story.order['id']}/cancel")
    state = await story.state()
    assert (state["status"], state["eta"], state["reasons"]) == ("cancelled", None, [])
    assert reached(state) == STAGES[:3]
    page = await story.page()
    assert "Cancelled" in page
    assert 'aria-current="step"' not in page
    # Nothing more is to come, and nobody is told that it is.
    assert re.findall(r'<li class="(\w+)"', page) == ["done", "done", "done", "stopped"]
    assert "still to come" not in page


# --- late, and why ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("due_s", "late", "words"),
    [
        (3600, "", "Requested for today, 18:46"),
        (525, "maybe", "May be later than requested"),
        (400, "yes", "Later than requested"),
    ],
)
async def test_an_order_that_will_be_late_says_so_before_it_is(
    house: House, due_s: float, late: str, words: str
) -> None:
    story = await Story.begin(house, due_at=iso(NOW_S + due_s))
    await story.planned()
    await story.making(26)
    state = await story.state()
    assert state["late"] == late, state
    assert words in await story.page()


async def test_an_order_that_came_late_does_not_hide_it(house: House) -> None:
    story = await Story.begin(house, due_at=iso(NOW_S + 300))
    await story.planned()
    await story.making(40)
    await story.arrived(40, 600.0)
    assert (await story.state())["late"] == "yes"
    assert "Delivered later than requested" in await story.page()


async def test_an_order_that_nobody_can_make_says_so_until_somebody_takes_it(house: House) -> None:
    story = await Story.begin(house)
    await story.waiting(50.0)
    state = await story.state()
    assert (state["reasons"], state["eta"]) == (["no_machine"], None)
    assert "No machine that can make a part of this order is working at the moment." in await story.page()
    await story.planned()
    state = await story.state()
    assert state["reasons"] == []
    assert state["eta"] is not None


async def test_a_machine_that_is_broken_is_named_as_a_machine_and_nothing_is_promised(house: House) -> None:
    story = await Story.begin(house)
    await story.planned()
    await story.making(12, MachineStatus.ERROR)
    state = await story.state()
    assert (state["reasons"], state["eta"]) == (["repair"], None)


async def test_want_of_material_is_told_while_it_lasts(house: House) -> None:
    story = await Story.begin(house)
    await story.planned()
    await story.making(12, MachineStatus.STARVED)
    state = await story.state()
    assert state["reasons"] == ["material"]
    assert state["eta"] is not None
    story.beat(MACHINE, 240.0, MachineStatus.PRODUCING, made=12)
    assert (await story.state())["reasons"] == []


MATERIAL = next(product.bill[0].material for product in PLANT.products if product.id == PRODUCT)

WAIT = MaterialWait(item=MATERIAL, quantity=5, short=("S3",), silent=("S4",))

NAME = next(material.name for material in PLANT.materials if material.id == MATERIAL)


@pytest.mark.parametrize(
    ("language", "words"),
    [("en", "Production waits for material"), ("de", "Die Produktion wartet auf Material")],
)
async def test_the_material_is_told_by_name_and_nothing_of_its_storages(
    house: House, language: str, words: str
) -> None:
    story = await Story.begin(house)
    await story.planned()
    now_s = await story.making(12, MachineStatus.STARVED)
    story.beat(MACHINE, now_s, MachineStatus.STARVED, made=12, waits=(WAIT,))
    state = await story.state()
    assert (state["reasons"], state["materials"]) == (["material"], [NAME])
    page = await story.page(**{"Accept-Language": language})
    assert f"{words}: {NAME}." in page
    assert not re.search(r"\bS[34]\b", page)
    # What is still in front of the machine is used up first: nobody waits meanwhile.
    story.beat(MACHINE, now_s, MachineStatus.PRODUCING, made=13, waits=(WAIT,))
    state = await story.state()
    assert (state["reasons"], state["materials"]) == ([], [])


async def test_an_order_whose_turn_has_not_come_tells_what_its_machine_has_asked_for_in_vain(
    house: House,
) -> None:
    story = await Story.begin(house)
    await story.planned()
    story.now(101.0)
    other = GoalBrief("strategist.1-1", PRODUCT, 4, 0, 0)
    own = GoalBrief(GOAL, PRODUCT, story.quantity, 0, 0)
    house.bus.say(machine_heartbeat(MACHINE, 9, at_s=101.0, goals=(other, own), waits=(WAIT,)))
    assert (await story.state())["materials"] == [NAME]
    # Nothing is heard of the machine any more: what it has waited for is a memory.
    story.now(3600.0)
    assert (await story.state())["materials"] == []


async def test_a_more_urgent_goal_of_its_machine_moves_the_range(house: House) -> None:
    story = await Story.begin(house)
    await story.planned(finish_s=150.0)
    making = next(spec for spec in PLANT.machines if spec.id == MACHINE).makes[0]
    work_s = 100 * making.cycle_s
    urgent = GoalBrief("strategist.1-1", making.product, 100, 0, 0)
    own = GoalBrief(GOAL, PRODUCT, story.quantity, 0, 0)
    story.now(101.0)
    house.bus.say(machine_heartbeat(MACHINE, 9, at_s=101.0, goals=(own, urgent)))
    before = (await story.state())["eta"]
    assert before["latest"] < iso(NOW_S + 0.5 * work_s)
    story.now(102.0)
    house.bus.say(machine_heartbeat(MACHINE, 10, at_s=102.0, goals=(urgent, own)))
    after = (await story.state())["eta"]
    assert after["earliest"] > iso(NOW_S + 0.8 * work_s)


@pytest.mark.parametrize(
    ("language", "words"),
    [("en", "More urgent work came before"), ("de", "Dringendere Arbeit kommt"), ("es", "más urgente")],
)
async def test_a_promise_that_its_machine_has_moved_counts_and_is_explained(
    house: House, language: str, words: str
) -> None:
    story = await Story.begin(house)
    await story.planned(finish_s=600.0)
    story.now(120.0)
    urgent = GoalBrief("strategist.1-1", PRODUCT, 4, 0, 0)
    own = GoalBrief(GOAL, PRODUCT, story.quantity, 0, 0)
    house.bus.say(machine_heartbeat(MACHINE, 9, at_s=120.0, goals=(urgent, own)))
    before = await story.state()
    assert before["reasons"] == []
    await story.tell(MACHINE, 120.0, PromiseMoved(GOAL, 9000.0, 3))
    state = await story.state()
    assert state["reasons"] == ["overtaken"]
    assert state["eta"]["earliest"] >= iso(NOW_S + 8100.0) > before["eta"]["latest"]
    page = await story.page(**{"Accept-Language": language})
    assert words in page
    # Once its turn has come it does not wait any more.
    house.bus.say(machine_heartbeat(MACHINE, 10, at_s=121.0, goals=(own,)))
    assert (await story.state())["reasons"] == []


async def test_the_want_of_material_of_another_order_is_none_of_this_one(house: House) -> None:
    story = await Story.begin(house)
    await story.planned()
    story.beat(MACHINE, 101.0, MachineStatus.STARVED, goal="strategist.1-1")
    assert (await story.state())["reasons"] == []


async def test_a_machine_that_failed_is_told_and_what_is_missing_is_promised_when_it_is_taken(
    house: House,
) -> None:
    story = await Story.begin(house)
    await story.planned()
    await story.lost(200.0)
    state = await story.state()
    assert (state["reasons"], state["eta"]) == (["handed_on"], None)
    await story.planned("strategist.1-8", OTHER_MACHINE)
    story.now(210.0)
    story.beat(OTHER_MACHINE, 210.0, goal="strategist.1-8")
    state = await story.state()
    assert state["reasons"] == ["handed_on"]
    assert state["eta"] is not None


async def test_goods_that_are_stuck_on_their_way_are_told(house: House) -> None:
    story = await Story.begin(house)
    await story.planned()
    now_s = await story.making(40)
    await story.leaving(now_s)
    brief = TaskBrief(WAY_OUT, 1, PRODUCT, 4, MACHINE, "delivery", now_s + 300, trouble=Reason.SILENT)
    house.bus.say(
        MachineHeartbeat(
            machine=MACHINE, incarnation=1, seq=99, at_s=now_s, status=MachineStatus.IDLE, tasks=(brief,)
        )
    )
    assert (await story.state())["reasons"] == ["held_up"]


async def test_nothing_is_promised_when_nothing_is_heard_of_the_machine(house: House) -> None:
    story = await Story.begin(house)
    await story.planned()
    now_s = await story.making(12)
    assert (await story.state())["eta"] is not None
    story.now(now_s + 3600)
    state = await story.state()
    # Nobody has said why: so no reason is given, either.
    assert (state["eta"], state["reasons"]) == (None, [])


# --- the reader -------------------------------------------------------------------------------------


async def test_the_language_is_the_browsers_until_the_reader_chooses_one_which_is_remembered(
    house: House,
) -> None:
    story = await Story.begin(house)
    assert '<html lang="de">' in await story.page(**GERMAN)
    chosen = await house.client.get(f"{story.path}?lang=es", headers=GERMAN)
    assert '<html lang="es">' in chosen.text
    cookie = chosen.headers["set-cookie"]
    assert "dray_language=es" in cookie
    assert "Path=/;" in cookie
    assert "SameSite=lax" in cookie
    # The client keeps cookies, as a browser does.
    assert '<html lang="es">' in await story.page(**GERMAN)
    assert (
        'href="?lang=es" lang="es" hreflang="es" aria-label="ES, Español" aria-current="true"'
        in await story.page()
    )


async def test_a_language_that_is_none_is_not_remembered(house: House) -> None:
    answer = await house.client.get(f"{(await Story.begin(house)).path}?lang=xx%0d%0aX-Evil:1")
    assert '<html lang="en">' in answer.text
    assert "set-cookie" not in answer.headers
    assert "x-evil" not in answer.headers


async def test_times_are_the_readers_once_the_zone_is_known(house: House) -> None:
    story = await Story.begin(house)
    house.client.cookies.set("dray.zone", "Asia/Tokyo")
    page = await story.page()
    assert "Times are in Asia/Tokyo" in page
    assert "Today, 02:46" in page
    house.client.cookies.set("dray.zone", "../../etc/passwd")
    assert "passwd" not in await story.page()


async def test_a_page_has_one_heading_and_landmarks_and_says_changes_politely(house: House) -> None:
    page = await (await Story.begin(house)).page()
    assert page.count("<h1") == 1
    for part in ("<header", "<nav", "<main", "<footer", 'role="status"', 'class="skip" href="#order"'):
        assert part in page
    assert re.findall(r"<h(\d)", page) == ["1", "2", "2", "3"]


async def test_a_gateway_without_panels_tells_a_customer_to_come_back(url: str, tmp_path: Path) -> None:
    async with gateway(url, panels=Panels(tmp_path)) as house:
        story = await Story.begin(house)
        answer = await house.client.get(story.path)
    assert answer.status_code == 503
    assert "try again later" in answer.text
    assert_private(answer.headers)
