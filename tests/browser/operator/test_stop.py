"""Hands on Stop: whatever comes, goes and fails, the hand that reaches for a vehicle meets that one."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from random import Random

import pytest
from complaints import Complaints
from gateway_kit import PIN, House
from heartbeats import machine_heartbeat
from open_house import OpenHouse
from playwright.sync_api import Page, expect
from puppets import LATER_S, Puppet
from tablet_kit import (
    LYING,
    PHONE,
    STATION,
    THUMB_PX,
    UPRIGHT,
    WHO,
    Enter,
    ask_for_help,
    beat,
    card,
    forgive,
    kinds,
    stop_of,
)
from variants import variants
from wall_clock import NOW_S

from dray.messages import AtvStatus, Brief, BufferLevel, CommandKind, HelpWanted, Phase, TaskBrief
from dray.messages import Role as MessageRole

Screenshot = Callable[..., Path]

AWAY = (25.0, 35.0)
"""Outside of the area, by more than a stop reaches."""

ELSEWHERE = ("M1", "M2")
"""Machines outside of the area."""

KEPT_MS, SETTLE_MS = 4_000, 600
"""Until a place may be given away, and until its new owner may be touched: some more than the panel waits."""

PASSING = 50
"""Vehicles that pass a station."""

MOMENTS = [40, pytest.param(320, marks=pytest.mark.campaign)]
"""At which somebody comes or goes, on each of three screens: 960 in all."""

EACH_PICTURE = """(() => {
    window.looks = 0;
    window.unseen = [];
    const look = () => {
        window.looks += 1;
        for (const tile of document.querySelectorAll(".stop:not(.away)")) {
            const {left, right, top, bottom} = tile.getBoundingClientRect();
            const seen = left >= 0 && right <= innerWidth && top >= 0 && bottom <= innerHeight;
            if (!seen) window.unseen.push([tile.id, window.looks, left, top]);
        }
        requestAnimationFrame(look);
    };
    requestAnimationFrame(look);
})()"""
"""Looks at every picture of the page, not only at those that a test waits for."""

NEAR_AT_MOST = {1024: 14, 800: 10, 390: 6}
"""At one time, by the width of the page: so many Stops stand in two lines."""

ALL_IN_SIGHT = """near => {
    const tiles = [...document.querySelectorAll(".stop:not(.away)")].map(tile => [tile.id.slice(5), tile.getBoundingClientRect()]);
    const seen = tiles.filter(([, {left, right, top, bottom}]) =>
        left >= 0 && right <= innerWidth && top >= 0 && bottom <= innerHeight).map(([atv]) => atv);
    return tiles.length === near.length && near.every(atv => seen.includes(atv));
}"""

SHOWN_MS = 400
"""On a clock that stands still: until a frame is shown, and not yet until a place has settled."""


async def crowd(house: House, count: int) -> dict[str, Puppet]:
    """So many vehicles more, all over the area. Machines elsewhere go by the same clock: a single one is corrected."""
    for machine in ELSEWHERE:
        house.bus.say(machine_heartbeat(machine, at_s=LATER_S))
    places = [(f"ATV{n}", 16.0 + n % 10 * 3.0, 13.5 + n // 10 * 0.4) for n in range(10, 10 + count)]
    return {atv: await Puppet.join(house, atv, x_m, y_m) for atv, x_m, y_m in places}


def drive(vehicle: Puppet, x_m: float, y_m: float) -> Callable[[House], object]:
    async def drive(_house: House) -> None:
        vehicle.x_m, vehicle.y_m = x_m, y_m
        vehicle.beat()

    return drive


def under(page: Page, spots: list[tuple[float, float]]) -> list[str]:
    """Whose Stop lies under each of these points; empty for none."""
    return page.evaluate(
        "spots => spots.map(([x, y]) => document.elementFromPoint(x, y)?.closest('.stop')?.id ?? '')", spots
    )


def middles(page: Page) -> list[tuple[float, float]]:
    boxes = [each.bounding_box() for each in page.locator(".stop").all()]
    return [(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2) for box in boxes if box]


# --- places ------------------------------------------------------------------------------------------


def test_whatever_happens_no_stop_comes_under_a_hand_that_was_over_another_one(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter, complaints: Complaints
) -> None:
    vehicles |= house.do(lambda inside: crowd(inside, 4))
    page = enter()
    expect(page.locator(".stop")).to_have_count(len(vehicles))
    spots = middles(page)
    owners = under(page, spots)
    assert all(owners)

    def look() -> None:
        # Where one has left nothing is shown after some seconds.
        assert all(now in {owner, ""} for now, owner in zip(under(page, spots), owners, strict=True))

    house.do(drive(vehicles["ATV2"], *AWAY))
    expect(stop_of(page, "ATV2")).to_contain_text("not near")
    look()
    house.do(ask_for_help(vehicles["ATV12"]))
    expect(stop_of(page, "ATV12")).to_contain_text("asks for help")
    look()
    house.do(lambda inside: Puppet.join(inside, "ATV1", 22.0, 14.5))
    expect(stop_of(page, "ATV1")).to_be_attached()
    look()
    vehicles["ATV11"].deaf = True
    stop_of(page, "ATV11").tap()
    expect(stop_of(page, "ATV11")).to_contain_text("not confirmed")
    look()
    stop_of(page, "ATV10").tap()
    expect(stop_of(page, "ATV10")).to_contain_text("stopped")
    look()
    house.do(beat(vehicles["ATV13"], status=AtvStatus.CHARGING))
    house.do(drive(vehicles["ATV2"], 25.0, 14.5))
    expect(stop_of(page, "ATV2")).to_contain_text("m")
    assert under(page, spots) == owners
    forgive(complaints, "status of 504")


@pytest.mark.slow
def test_a_place_that_has_a_new_owner_counts_no_touch_at_first_and_says_so(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter
) -> None:
    page = enter(before=lambda page: page.clock.install(time=NOW_S))
    expect(stop_of(page, "ATV2")).to_be_visible()
    page.clock.pause_at(NOW_S + 60)
    (spot, _) = middles(page)
    house.do(drive(vehicles["ATV2"], *AWAY))
    _run_until(page, "ATV2", "not near")
    page.clock.run_for(KEPT_MS)
    new = house.do(lambda inside: Puppet.join(inside, "ATV9", 25.0, 14.5))
    # As soon as it is there, whatever it says: a slow computer tells the rest later.
    _run_until(page, "ATV9", "ATV9")
    assert under(page, [spot]) == ["stop-ATV9"]
    page.touchscreen.tap(*spot)
    expect(stop_of(page, "ATV9")).to_contain_text("touch again")
    page.clock.run_for(SETTLE_MS)
    assert kinds(new) == []
    page.touchscreen.tap(*spot)
    _run_until(page, "ATV9", "stopped")
    assert kinds(new) == [CommandKind.STOP]
    page.clock.resume()


def _run_until(page: Page, atv: str, text: str) -> None:
    """Let the page's clock go on, a frame's time after another, until that is shown."""
    for _ in range(200):
        if stop_of(page, atv).count() and text in (stop_of(page, atv).text_content() or ""):
            return
        page.clock.run_for(50)
    raise AssertionError(f"{atv} never said {text}")


# --- two lines ---------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("count", variants([1, 8, 50], 50))
@pytest.mark.parametrize("size", variants([LYING, UPRIGHT]), ids=["lying", "upright"])
def test_the_bar_is_two_lines_at_most_that_hide_nothing_however_many_there_are(
    house: OpenHouse, enter: Enter, screenshot: Screenshot, count: int, size: dict[str, int]
) -> None:
    crew = house.do(lambda inside: crowd(inside, count))
    asking = min(crew)
    house.do(ask_for_help(crew[asking]))
    page = enter(viewport=size)
    expect(page.locator(".stop")).to_have_count(count)
    tops = page.locator(".stop").evaluate_all(
        "all => all.map(each => Math.round(each.getBoundingClientRect().top))"
    )
    assert len(set(tops)) == (1 if count == 1 else 2)
    main = page.locator("main").bounding_box()
    assert main is not None
    assert main["height"] > 0.48 * size["height"]
    expect(card(page, asking).locator(".promises button").last).to_be_in_viewport(ratio=1)
    assert page.evaluate("document.documentElement.scrollHeight <= innerHeight")
    screenshot(page, f"operator-{count}-vehicles-{'lying' if size is LYING else 'upright'}")
    last = page.locator(".stop").last
    later = page.get_by_role("button", name="Later places")
    for _ in range(count):
        # At the end of the line the button goes dead a frame later: also between a look and a tap.
        if not later.count() or not later.is_enabled():
            break
        later.evaluate("button => button.click()")
    expect(last).to_be_in_viewport(ratio=1)
    box = last.bounding_box()
    assert box is not None
    assert min(box["width"], box["height"]) >= THUMB_PX


@pytest.mark.slow
@pytest.mark.parametrize("moments", MOMENTS)
@pytest.mark.parametrize("size", [LYING, UPRIGHT, PHONE], ids=["lying", "upright", "phone"])
def test_of_many_that_pass_none_that_is_near_is_ever_out_of_sight(
    house: OpenHouse,
    enter: Enter,
    screenshot: Screenshot,
    size: dict[str, int],
    moments: int,
    request: pytest.FixtureRequest,
) -> None:
    crew = house.do(lambda inside: crowd(inside, PASSING))
    near = {atv: (vehicle.x_m, vehicle.y_m) for atv, vehicle in crew.items()}
    held = dict.fromkeys(crew, AWAY)
    random, most = Random(size["width"]), NEAR_AT_MOST[size["width"]]
    for atv in crew:
        house.do(drive(crew[atv], *AWAY))
    page = enter(viewport=size, before=lambda page: page.add_init_script(EACH_PICTURE))
    for _ in range(moments):
        moving = random.sample(sorted(crew), 3)
        for atv in moving:
            if held[atv] != AWAY:
                held[atv] = AWAY
            elif sum(place != AWAY for place in held.values()) < most:
                held[atv] = near[atv]
            house.do(drive(crew[atv], *held[atv]))
        here = sorted(atv for atv in crew if held[atv] != AWAY)
        page.wait_for_function(ALL_IN_SIGHT, arg=here)
    assert page.evaluate("() => window.looks") > 0
    assert page.evaluate("() => window.unseen") == []
    screenshot(page, f"operator-passing-{request.node.callspec.id}")


# --- what is not confirmed ---------------------------------------------------------------------------


@pytest.mark.slow
def test_an_unconfirmed_stop_stays_in_sight_wherever_its_vehicle_goes(
    house: OpenHouse,
    vehicles: dict[str, Puppet],
    enter: Enter,
    screenshot: Screenshot,
    complaints: Complaints,
) -> None:
    gone = vehicles["ATV2"]
    gone.deaf = True
    page = enter()
    stop_of(page, "ATV2").tap()
    house.do(drive(gone, *AWAY))
    expect(card(page, "ATV2")).to_have_count(0)
    worry = page.get_by_role("list", name="Stops that are not confirmed")
    expect(worry).to_contain_text("ATV2 not confirmed")
    expect(worry).to_contain_text("not near")
    expect(stop_of(page, "ATV2")).to_contain_text("not confirmed")
    screenshot(page, "operator-unconfirmed")
    page.reload()
    expect(worry).to_contain_text("ATV2 not confirmed")
    expect(stop_of(page, "ATV2")).to_contain_text("not confirmed")
    gone.deaf = False
    house.do(drive(gone, 25.0, 14.5))
    stop_of(page, "ATV2").tap()
    expect(worry).to_have_count(0)
    expect(stop_of(page, "ATV2")).to_contain_text("stopped")
    forgive(complaints, "status of 504")


@pytest.mark.slow
def test_an_unconfirmed_stop_goes_when_a_person_says_that_it_was_seen_to(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter, complaints: Complaints
) -> None:
    vehicles["ATV2"].deaf = True
    page = enter()
    stop_of(page, "ATV2").tap()
    expect(stop_of(page, "ATV2")).to_contain_text("not confirmed")
    page.get_by_role("button", name="I have looked ATV2").tap()
    expect(page.get_by_role("list", name="Stops that are not confirmed")).to_have_count(0)
    expect(stop_of(page, "ATV2")).not_to_contain_text("not confirmed")
    forgive(complaints, "status of 504")


# --- whose tablet ------------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_tablet_whose_login_was_replaced_says_so_and_keeps_stop(
    house: OpenHouse,
    vehicles: dict[str, Puppet],
    enter: Enter,
    screenshot: Screenshot,
    complaints: Complaints,
) -> None:
    page = enter()
    expect(stop_of(page, "ATV2")).to_be_visible()
    house.do(_log_in_elsewhere)
    banner = page.get_by_role("alert")
    expect(banner).to_contain_text("logged in at another station")
    expect(card(page, "ATV2").get_by_role("button", name="At most 50")).to_be_disabled()
    stop_of(page, "ATV2").tap()
    expect(card(page, "ATV2").locator(".command")).to_contain_text("confirmed by the vehicle")
    assert kinds(vehicles["ATV2"]) == [CommandKind.STOP]
    screenshot(page, "operator-login-replaced")
    forgive(complaints, "status of 401")


async def _log_in_elsewhere(inside: House) -> None:
    answer = await inside.visitor().post("/login", data={"name": WHO, "secret": PIN})
    assert answer.status_code == 303
    await inside.access.watch.check()


@pytest.mark.slow
def test_a_tablet_whose_person_was_disabled_says_that_stop_does_not_work_from_it(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter, complaints: Complaints
) -> None:
    page = enter()
    expect(stop_of(page, "ATV2")).to_be_visible()

    async def disable(inside: House) -> None:
        async with inside.store.write() as work:
            await work.people.change(WHO, disabled_at_s=NOW_S)
        await inside.access.watch.check()

    house.do(disable)
    expect(page.get_by_role("alert")).to_contain_text("Stop does not work from this tablet any more")
    stop_of(page, "ATV2").tap()
    expect(card(page, "ATV2").locator(".stage")).to_have_text(["sent", "refused"])
    assert kinds(vehicles["ATV2"]) == []
    page.close()  # Else it may ask once more.
    forgive(complaints, "status of 401")


# --- what is said of a vehicle -----------------------------------------------------------------------


@pytest.mark.slow
def test_of_a_vehicle_that_a_person_has_stopped_nobody_says_that_it_asks_for_help(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter
) -> None:
    page = enter()
    waits = HelpWanted(until_s=170.0)
    house.do(beat(vehicles["ATV2"], status=AtvStatus.STOPPED, help=waits))
    expect(card(page, "ATV2").locator(".tag")).to_have_text(["stopped"])
    expect(card(page, "ATV2").get_by_role("timer")).to_contain_text("until another vehicle takes over")
    expect(stop_of(page, "ATV2")).to_contain_text("stopped")
    expect(page.locator("body")).not_to_contain_text("asks for help")


@pytest.mark.slow
def test_a_silent_vehicle_promises_nothing_any_more(
    house: OpenHouse, vehicles: dict[str, Puppet], enter: Enter
) -> None:
    task = TaskBrief(
        task="M8-1",
        epoch=1,
        item="housing",
        quantity=24,
        source="S3",
        destination=STATION,
        deadline_s=LATER_S + 900.0,
        primary="ATV2",
    )
    brief = Brief(
        task="M8-1",
        epoch=1,
        role=MessageRole.PRIMARY,
        coordinator=STATION,
        item="housing",
        quantity=24,
        phase=Phase.CARRYING,
        due_s=LATER_S,
    )
    stock = (BufferLevel(item="housing", level=11, capacity=72, reorder_point=20, on_order=24),)

    async def carry(inside: House) -> None:
        inside.bus.say(machine_heartbeat(STATION, 2, at_s=LATER_S, buffers=stock, tasks=(task,)))
        vehicles["ATV2"].beat(status=AtvStatus.WORKING, task=brief)

    house.do(carry)
    page = enter()
    material = page.get_by_role("region", name="Material")
    expect(card(page, "ATV2")).to_contain_text("there")
    expect(material).to_contain_text("+24 with ATV2,")
    house.do(beat(vehicles["ATV2"], at_s=-100.0))
    expect(stop_of(page, "ATV2")).to_contain_text("silent")
    expect(card(page, "ATV2").locator(".doing")).not_to_contain_text("there")
    expect(material).to_contain_text("+24 with ATV2, silent")
