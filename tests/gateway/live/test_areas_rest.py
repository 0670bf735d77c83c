"""The area rule over REST: every route, every role and every area; and an operator commands in the own areas alone."""

from __future__ import annotations

import re

import httpx
import jsonschema_rs
import pytest
from answers import problem
from areas_kit import (
    AREAS,
    ATV,
    FLOOR,
    MACHINE,
    ORDER,
    TASK,
    after,
    every_area,
    everything,
    secrets_of,
    words,
)
from fake_injector import FakeInjector
from gateway_kit import PRODUCT, House, gateway
from heartbeats import atv_heartbeat

from dray.gateway.access.principal import Role
from dray.gateway.access.rules import RULES
from dray.gateway.live.visibility import AreaVisibility
from dray.messages import CommandAnswered, CommandRefusal, Message, Pose, VehicleCommand

pytestmark = pytest.mark.anyio


# --- REST: every route, every role, every area ------------------------------------------------------


async def operator_of(house: House, area: str) -> httpx.AsyncClient:
    """The browser of an area's operator."""
    return await house.log_in(f"operator-{area.lower()}", Role.OPERATOR, area)


def paths(template: str, names: dict[str, str]) -> str:
    """A path with the names of one area's things in it."""
    for field, name in names.items():
        template = template.replace(f"{{{field}}}", name)
    return template


def things(area: str) -> dict[str, str]:
    return {
        "atv": ATV[area],
        "agent": ATV[area],
        "machine": MACHINE[area],
        "task": TASK[area],
        "alert": f"atv_help-{ATV[area]}",
        "order": ORDER,
        "product": PRODUCT,
        "fault": "f1",
        "token": "t" * 20,
    }


API = sorted((method, path) for method, path in RULES if path.startswith("/api/") and path != "/api/stream")


async def busy(house: House) -> None:
    """Something goes on in every area, and there is an order."""
    house.bus.strategist()
    await house.place(customer="Muster")
    await house.say(everything())
    house.projection.look(house.wall())


async def test_every_route_gives_an_operator_of_any_area_nothing_of_another(url: str) -> None:
    async with gateway(url, faults=FakeInjector(), command_timeout_s=0.01) as house:
        await busy(house)
        for area in AREAS:
            client = await operator_of(house, area)
            for method, template in API:
                for other in AREAS if "{" in template else (area,):
                    path = paths(template, things(other))
                    answer = await client.request(method, path)
                    assert answer.status_code != 500, (method, path)
                    if template in {"/api/openapi.json", "/api/docs"}:
                        continue
                    # What the caller has typed comes back in a problem; nothing else does.
                    typed = words(path) if answer.status_code >= 400 else set()
                    leaked = (words(answer.text) & secrets_of(area)) - typed
                    assert leaked == set(), (method, path, answer.text)
                    if other != area and "{" in template and method == "GET":
                        assert answer.status_code in (403, 404), (method, path)


@pytest.mark.parametrize("role", ["admin", "manager"])
async def test_whoever_has_the_whole_plant_is_refused_nothing(url: str, role: str) -> None:
    async with gateway(url, faults=FakeInjector()) as house:
        await busy(house)
        client = house.client if role == "admin" else await house.log_in("boss")
        for area in AREAS:
            for method, template in API:
                # Here is one of each that has an area; of orders, drafts and transports there is none by these names.
                named = re.findall(r"\{(\w+)\}", template)
                if method == "GET" and not {"token", "order", "draft", "schedule", "transport"} & set(named):
                    answer = await client.get(paths(template, things(area)))
                    # No scenario is played here.
                    expected = 409 if template == "/api/scenario" else 200
                    assert answer.status_code == expected, (template, answer.text)
        assert words((await client.get("/api/atvs")).text) >= {ATV[area] for area in AREAS}


@every_area
async def test_what_stands_elsewhere_is_not_told_from_what_does_not_exist(url: str, area: str) -> None:
    async with gateway(url) as house:
        await busy(house)
        client = await operator_of(house, area)
        for noun, names, nobody in (
            ("atvs", ATV, "ATV999"),
            ("machines", MACHINE, "M999"),
            ("tasks", TASK, "M999-1"),
        ):
            assert (await client.get(f"/api/{noun}/{names[area]}")).status_code == 200
            hidden = await client.get(f"/api/{noun}/{names[after(area)]}")
            missing = await client.get(f"/api/{noun}/{nobody}")
            assert hidden.status_code == missing.status_code == 404
            assert hidden.text.replace(names[after(area)], nobody) == missing.text


@every_area
async def test_the_plant_file_ends_at_the_border(url: str, area: str) -> None:
    async with gateway(url) as house:
        client = await operator_of(house, area)
        file = (await client.get("/api/plant")).json()
        document = (await house.client.get("/api/openapi.json")).json()
    shape = {"$ref": "#/components/schemas/PlantFile", "components": document["components"]}
    jsonschema_rs.validator_for(shape).validate(file)
    assert [each["id"] for each in file["areas"]] == [area]
    machines = [m for m in FLOOR.machines if area in FLOOR.areas_at(*FLOOR.position_of(m))]
    assert [each["id"] for each in file["machines"]] == machines
    assert file["fleet"] == []
    nodes = {each["id"] for each in file["nodes"]}
    assert all({lane["start"], lane["end"]} <= nodes for lane in file["lanes"])
    for kind in ("machines", "storages", "chargers", "parkings", "warehouses"):
        assert {each["node"] for each in file[kind]} <= nodes
    assert {machine["station"] for machine in file["machines"]} == {each["id"] for each in file["stations"]}


# --- commands ---------------------------------------------------------------------------------------


def deaf_vehicles(house: House) -> None:
    """Vehicles that obey at once."""
    for atv in ATV.values():

        def receive(sender: str, message: Message, atv: str = atv) -> None:
            if isinstance(message, VehicleCommand):
                house.bus.tell(atv, sender, CommandAnswered(command=message.command, done=True))

        house.bus.join(atv, receive)


@every_area
async def test_an_operator_commands_what_stands_in_the_area_and_nothing_else(url: str, area: str) -> None:
    async with gateway(url) as house:
        await busy(house)
        deaf_vehicles(house)
        client = await operator_of(house, area)
        stop = await client.post(f"/api/atvs/{ATV[area]}/commands", json={"kind": "stop"})
        assert stop.status_code == 200, stop.text
        for body in ({"kind": "resume"}, {"kind": "set_speed", "speed_frac": 0.5}):
            answer = await client.post(f"/api/atvs/{ATV[area]}/commands", json=body)
            assert answer.status_code == 200, answer.text
            told = problem(
                await client.post(f"/api/atvs/{ATV[after(area)]}/commands", json=body), 403, "not-allowed"
            )
            nobody = problem(await client.post("/api/atvs/ATV999/commands", json=body), 403, "not-allowed")
            assert told["detail"].replace(ATV[after(area)], "ATV999") == nobody["detail"]
            assert area in told["detail"]
        assert house.bus.sent_to(ATV[after(area)], VehicleCommand) == []
        commands = house.bus.sent_to(ATV[area], VehicleCommand)
        for command in commands:
            assert command.grant is not None
            assert (command.grant.areas, command.grant.everywhere) == ((area,), False)
            assert command.grant.person == f"person:operator-{area.lower()}"


async def test_a_vehicles_refusal_names_none_that_stands_elsewhere(url: str) -> None:
    area, other = AREAS[0], ATV[after(AREAS[0])]
    async with gateway(url) as house:
        await busy(house)

        def refuse(sender: str, message: Message) -> None:
            if isinstance(message, VehicleCommand):
                answer = CommandAnswered(message.command, False, CommandRefusal.FAULTY, f"blocked by {other}")
                house.bus.tell(ATV[area], sender, answer)

        house.bus.join(ATV[area], refuse)
        client = await operator_of(house, area)
        answer = await client.post(f"/api/atvs/{ATV[area]}/commands", json={"kind": "acknowledge"})
        shown = AreaVisibility(house.projection, frozenset({area}))
        (command,) = house.projection.commands.views()
        seen = shown.command(command)
    assert other in command.detail
    assert seen is not None
    assert answer.json()["detail"] == seen.detail == "blocked by *"
    assert answer.json()["text"] == seen.text == "its sensors still report a problem: blocked by *"


@every_area
async def test_a_stop_is_passed_on_wherever_the_picture_shows_the_vehicle(url: str, area: str) -> None:
    there = after(area)
    atv = ATV[there]
    async with gateway(url) as house:
        await busy(house)
        deaf_vehicles(house)
        client = await operator_of(house, area)
        answer = await client.post(f"/api/atvs/{atv}/commands", json={"kind": "stop", "command": "stop-1"})
        assert (answer.status_code, answer.json()["done"]) == (200, True), answer.text
        (command,) = house.bus.sent_to(atv, VehicleCommand)
        assert command.grant is not None
        assert (command.grant.areas, command.grant.everywhere) == ((area,), False), "and no more than that"
        told = problem(
            await client.post(f"/api/atvs/{atv}/commands", json={"kind": "resume"}), 403, "not-allowed"
        )
        assert area in told["detail"]
        for sees in (area, there):
            (shown,) = house.projection.commands.views()
            seen = AreaVisibility(house.projection, frozenset({sees})).command(shown)
            assert seen is not None
            assert (seen.id, seen.state) == ("stop-1", "confirmed")


async def test_a_stop_of_a_vehicle_that_was_never_heard_is_passed_on(url: str) -> None:
    async with gateway(url) as house:
        deaf_vehicles(house)
        client = await operator_of(house, AREAS[0])
        answer = await client.post("/api/atvs/ATV1/commands", json={"kind": "stop"})
    assert (answer.status_code, answer.json()["done"]) == (200, True), answer.text


async def test_what_the_vehicle_says_to_a_stop_from_elsewhere_is_told(url: str) -> None:
    home, there = AREAS[:2]
    async with gateway(url) as house:
        await busy(house)

        def refuse(sender: str, message: Message) -> None:
            if isinstance(message, VehicleCommand):
                house.bus.tell(
                    ATV[there],
                    sender,
                    CommandAnswered(message.command, done=False, reason=CommandRefusal.NOT_HERE),
                )

        house.bus.join(ATV[there], refuse)
        client = await operator_of(house, home)
        answer = await client.post(f"/api/atvs/{ATV[there]}/commands", json={"kind": "stop"})
        assert (answer.status_code, answer.json()["done"]) == (200, False)
        assert answer.json()["reason"] == CommandRefusal.NOT_HERE
        line = (await house.audit(action="vehicle.command"))[0]
        assert (line.target, line.result) == (ATV[there], "refused")
        assert b"outside of the areas that its grant names" in bytes(line.detail)


async def test_whoever_has_no_area_stops_nothing_and_nobody_stops_what_there_is_not(url: str) -> None:
    async with gateway(url) as house:
        await busy(house)
        nobody, ana = await house.log_in("nobody", Role.OPERATOR), await operator_of(house, AREAS[0])
        stop = {"kind": "stop"}
        problem(await nobody.post("/api/atvs/ATV1/commands", json=stop), 403, "not-allowed")
        problem(await ana.post("/api/atvs/ATV999/commands", json=stop), 404, "unknown-atv")
        assert house.bus.sent_to("ATV1", VehicleCommand) == house.bus.sent_to("ATV999", VehicleCommand) == []


async def test_what_is_no_stop_ends_at_the_border(url: str) -> None:
    border_y_m = max(corner.y_m for corner in FLOOR.areas["AREA2"].polygon)
    async with gateway(url) as house:
        deaf_vehicles(house)
        client = await operator_of(house, "AREA2")
        for seq, (away_m, status) in enumerate(((-0.1, 200), (0.1, 403)), 1):
            house.bus.say(atv_heartbeat("ATV1", seq, pose=Pose(30.0, border_y_m + away_m, 0.0)))
            answer = await client.post("/api/atvs/ATV1/commands", json={"kind": "resume"})
            assert answer.status_code == status, away_m


async def test_an_alert_elsewhere_cannot_be_acknowledged(url: str) -> None:
    home, there = AREAS[:2]
    async with gateway(url) as house:
        await busy(house)
        client = await operator_of(house, home)
        refused = await client.post(f"/api/alerts/atv_help-{ATV[there]}/acknowledge")
        problem(refused, 404, "unknown-alert")
        alert = house.projection.alerts.get(f"atv_help-{ATV[there]}")
        assert alert is not None
        assert alert.acknowledged_by == ""
        assert (await client.post(f"/api/alerts/atv_help-{ATV[home]}/acknowledge")).status_code == 200
