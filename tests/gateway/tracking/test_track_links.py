"""The customer's page: links that end, and nothing of the factory."""

from __future__ import annotations

import re
from collections.abc import AsyncIterator
from html.parser import HTMLParser

import pytest
from answers import problem
from fake_bus import PLANT
from gateway_kit import House
from tracking_kit import GERMAN, GOAL, MACHINE, OTHER_MACHINE, VEHICLE, WAY_OUT, Story, assert_private, iso
from variants import variants
from wall_clock import NOW_S

from dray.gateway.tracking.facts import KEPT_S
from dray.messages.heartbeat import MachineStatus
from dray.store.orders.tracking_links import Link

pytestmark = pytest.mark.anyio


# --- nothing of the factory -------------------------------------------------------------------------


class Words(HTMLParser):
    """What a page says: its text and the values of its attributes."""

    def __init__(self) -> None:
        super().__init__()
        self.said: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        # Built files are named by a hash, which may spell anything; and `light` is a theme, too.
        self.said += [
            value
            for _, value in attrs
            if value and not value.startswith("/static/") and ("name", "color-scheme") not in attrs
        ]

    def handle_data(self, data: str) -> None:
        self.said.append(data)


def ids_of_the_plant() -> set[str]:
    """Every id and name in the plant, except those of products, which are what was ordered."""
    plant = PLANT
    things = [
        *plant.nodes, *plant.warehouses, *plant.storages, *plant.chargers, *plant.stations, *plant.machines,
        *plant.vehicle_types, *plant.fleet, *plant.parkings, *plant.areas, *plant.materials,
    ]  # fmt: skip
    products = {product.id for product in plant.products} | {product.name for product in plant.products}
    found = {getattr(thing, field, "") for thing in things for field in ("id", "name")}
    # `delivery` is an English word as well: that is what a customer waits for.
    return found - products - {"", "delivery"}


async def whole_life(house: House) -> list[Story]:
    """Orders in every state, each with all that the factory could let slip."""
    stories = [await Story.begin(house, reference="4711")]
    told = await Story.begin(house, reference="4711", due_at=iso(NOW_S + 900))
    await told.planned()
    await told.lost(150.0)
    await told.waiting(160.0)
    stories.append(told)
    return stories


@pytest.mark.parametrize("language", variants(["en", "de", "es"]))
async def test_neither_page_nor_data_name_anything_of_the_factory(house: House, language: str) -> None:
    secret = ids_of_the_plant() | {GOAL, WAY_OUT, "strategist", "Muster GmbH", PLANT.plant}
    assert {MACHINE, VEHICLE, "S1", "a1"} <= secret
    names = re.compile(
        r"(?<![\w-])(?:" + "|".join(map(re.escape, sorted(secret, key=len)[::-1])) + r")(?![\w-])"
    )
    seen = 0
    for story in await whole_life(house):
        for step in ("as it is", "made", "sent", "stuck", "there"):
            if step == "made":
                await story.planned("strategist.1-8", OTHER_MACHINE)
                await story.making(40, MachineStatus.BLOCKED)
            elif step == "sent":
                await story.leaving(600.0)
            elif step == "there":
                await story.arrived(40, 700.0)
            page = Words()
            page.feed(await story.page(**{"Accept-Language": language}))
            data = await house.client.get(f"/api{story.path}")
            for said in (*page.said, data.text):
                assert not names.findall(said), (step, said)
            assert story.order["id"] not in "".join(page.said) + data.text
            seen += len(page.said)
    assert seen > 500


async def test_the_page_holds_no_script_or_style_of_its_own_and_asks_no_other_host(house: House) -> None:
    page = await (await Story.begin(house)).page()
    assert not re.search(r"<script(?![^>]*\bsrc=)|<style|\son\w+=|\bstyle=", page)
    assert not re.search(r'(?:src|href|action)="(?:https?:)?//', page)


async def test_what_the_customer_has_written_is_shown_and_not_obeyed(house: House) -> None:
    page = await (await Story.begin(house, reference='"><script>alert(1)</script>{{7*7}}')).page()
    assert "<script>alert" not in page
    assert "&lt;script&gt;" in page
    assert "{{7*7}}" in page


# --- links ------------------------------------------------------------------------------------------


async def assert_gone(house: House, path: str, status: int, words: str) -> None:
    """The page says why, in the reader's language, and so does the API."""
    page = await house.client.get(path)
    assert page.status_code == status
    assert page.headers["content-type"] == "text/html; charset=utf-8"
    assert words in page.text
    assert page.text.count("<h1>") == 1
    assert_private(page.headers)
    kind = "unknown-tracking-page" if status == 404 else "tracking-link-ended"
    answer = await house.client.get(f"/api{path}")
    problem(answer, status, kind)
    assert_private(answer.headers)


async def test_what_a_link_leads_to_stays_private(house: House) -> None:
    story = await Story.begin(house)
    for path in (story.path, f"/api{story.path}"):
        assert_private((await house.client.get(path)).headers)


async def test_a_link_that_was_taken_back_says_so(house: House) -> None:
    story = await Story.begin(house)
    async with house.store.write() as work:
        await work.links.revoke(story.token, NOW_S)
    await assert_gone(house, story.path, 410, "This link was taken back")


async def test_a_link_with_an_end_leads_to_the_order_until_then(house: House) -> None:
    story = await Story.begin(house)
    async with house.store.write() as work:
        await work.links.add("short", Link(story.order["id"], NOW_S, expires_at_s=NOW_S + 60))
    assert (await house.client.get("/track/short")).status_code == 200
    story.now(60.0)
    await assert_gone(house, "/track/short", 410, "This link has expired")
    assert (await house.client.get(story.path)).status_code == 200


async def test_the_link_of_an_order_ends_a_quarter_after_the_order(house: House) -> None:
    story = await Story.begin(house)
    await story.planned()
    await story.making(40)
    await story.arrived(40, 600.0)
    story.now(600.0 + KEPT_S - 1)
    await story.page()
    story.now(600.0 + KEPT_S)
    await assert_gone(house, story.path, 410, "This link has expired")


async def test_an_open_order_keeps_its_link_however_long_it_takes(house: House) -> None:
    story = await Story.begin(house)
    story.now(2 * KEPT_S)
    await story.page()


@pytest.mark.parametrize("token", ["guess", "%00", "%FF", "' OR 1=1 --", "%3Cscript%3E", "x" * 64])
async def test_a_token_that_nobody_has_leads_to_a_page_that_says_so(house: House, token: str) -> None:
    await Story.begin(house)
    await assert_gone(house, f"/track/{token}", 404, "This link leads nowhere")


async def test_a_very_long_token_leads_nowhere_either(house: House) -> None:
    assert (await house.client.get("/track/" + "x" * 5000)).status_code == 404


# --- asking again -----------------------------------------------------------------------------------


async def test_a_page_that_has_not_changed_is_not_sent_again(house: House) -> None:
    story = await Story.begin(house)
    first = await house.client.get(story.path)
    tag = {"If-None-Match": first.headers["etag"]}
    story.now(1.0)
    again = await house.client.get(story.path, headers=tag)
    assert (again.status_code, again.content, again.headers["etag"]) == (304, b"", first.headers["etag"])
    assert_private(again.headers)
    await story.planned()
    story.now(100.0)
    changed = await house.client.get(story.path, headers=tag)
    assert changed.status_code == 200
    assert changed.headers["etag"] != first.headers["etag"]


async def test_another_language_is_another_page(house: House) -> None:
    story = await Story.begin(house)
    english = await house.client.get(story.path)
    german = await house.client.get(story.path, headers=GERMAN | {"If-None-Match": english.headers["etag"]})
    assert german.status_code == 200
    assert german.headers["vary"] == "Accept-Language, Cookie, Accept-Encoding"


async def test_a_head_request_is_answered_like_the_page(house: House) -> None:
    story = await Story.begin(house)
    answer = await house.client.head(story.path)
    assert answer.status_code == 200
    assert answer.headers["etag"] == (await house.client.get(story.path)).headers["etag"]
    assert (await house.client.head("/track/guess")).status_code == 404
    problem(await house.client.post(story.path), 405, "method-not-allowed")


async def test_a_link_needs_no_body_but_what_is_sent_must_be_json(house: House) -> None:
    order = (await house.place())["id"]
    path = f"/api/orders/{order}/links"
    made = await house.client.post(path)
    assert (made.status_code, made.json()["expires_at_s"]) == (201, None)
    problem(await house.client.post(path, content=b'{"days": 1}'), 415, "not-called-json")

    async def pieces() -> AsyncIterator[bytes]:
        yield b'{"days": 1}'

    problem(await house.client.post(path, content=pieces()), 415, "not-called-json")


async def test_an_unknown_link_says_what_to_do(house: House) -> None:
    told = problem(await house.visitor().get("/api/track/guess"), 404, "unknown-tracking-page")
    assert (
        told["detail"]
        == "nothing has the link 'guess'; look whether all of it was copied, or ask for a new one"
    )


async def test_an_order_has_only_so_many_links_and_those_that_ended_do_not_pile_up(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("dray.store.orders.tracking_links.WORKING_MAX", 3)
    monkeypatch.setattr("dray.store.orders.tracking_links.ENDED_KEPT", 4)
    order = (await house.place())["id"]
    path = f"/api/orders/{order}/links"
    for _ in range(2):
        assert (await house.client.post(path, json={})).status_code == 201
    told = problem(await house.client.post(path, json={}), 409, "too-many-links")
    assert f"DELETE {path}" in told["detail"]
    for _ in range(3):
        assert (await house.client.delete(path)).status_code == 200
        house.wall.now_s += 1.0
        answers = [await house.client.post(path, json={"days": 1}) for _ in range(3)]
        assert [each.status_code for each in answers] == [201] * 3
    house.wall.now_s += 86_400.0
    newest = await house.client.post(path, json={})
    assert newest.status_code == 201, "what has run out counts no more"
    async with house.store.read() as work:
        links = await work.links.to(order)
    assert len(links) == 5
    page = newest.json()["tracking_url"].rpartition("/")[2]
    assert (await house.visitor().get(f"/api/track/{page}")).status_code == 200
