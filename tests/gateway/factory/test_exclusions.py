"""Shutting an agent out: a manager decides it, everybody is told, and it holds until it is taken back."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any

import pytest
from answers import problem
from areas_kit import AREAS, ATV, everything
from fake_bus import KEYS, PLANT, FakeBus
from gateway_kit import House, gateway
from heartbeats import atv_heartbeat, machine_heartbeat
from wall_clock import NOW_S

from dray.gateway.access.principal import Role, Scope
from dray.gateway.factory.exclusions import Exclusions
from dray.gateway.live.projection import Projection
from dray.gateway.live.timescale import TimeScale
from dray.gateway.live.views import AtvView, MachineView, ShutOutView
from dray.messages import CommandAnswered, CommandKind, EventsAsked, Message, ShutOut, VehicleCommand
from dray.messages.shutout import MAX_SHUT_OUT
from dray.store.factory.exclusions import Exclusion

pytestmark = pytest.mark.anyio

EVERY_S = Exclusions.EVERY_S
"""Outside tests."""


WHY = {"reason": "accepts transports and does not move"}

DECIDED = int(NOW_S * 1000)
"""The number of a decision at the beginning."""


def listener(bus: FakeBus, told: Callable[[], None] = lambda: None) -> list[ShutOut]:
    """What agents hear on the key of exclusions from now on; `told` is called with each."""
    heard: list[ShutOut] = []

    def receive(_sender: str, message: Message) -> None:
        if isinstance(message, ShutOut):
            heard.append(message)
            told()

    bus.join("M1", receive).subscribe(KEYS.shut_out)
    return heard


async def shut_out(house: House, agent: str = "ATV3", **body: Any) -> dict[str, Any]:
    answer = await house.client.post(f"/api/agents/{agent}/shut-out", json=WHY | body)
    assert answer.status_code == 200, answer.text
    told: dict[str, Any] = answer.json()
    return told


def atv(house: House, name: str = "ATV3") -> AtvView:
    view = house.projection.atvs.view(name)
    assert view is not None
    return view


def machine(house: House, name: str) -> MachineView:
    view = house.projection.machines.view(name)
    assert view is not None
    return view


async def test_whoever_is_shut_out_is_told_to_everybody_and_shown_with_the_reason(house: House) -> None:
    heard = listener(house.bus)
    house.bus.say(atv_heartbeat("ATV3"), machine_heartbeat("M8"))
    told = await shut_out(house)
    assert told == {"agent": "ATV3", "reason": WHY["reason"], "by": "Administrator", "at_s": NOW_S}
    assert set(heard) == {ShutOut(DECIDED, ("ATV3",))}
    await shut_out(house, "M8", reason="spindle")
    assert heard[-1] == ShutOut(DECIDED + 1, ("ATV3", "M8")), "each decision has a higher number"
    assert atv(house).shut_out == ShutOutView(by="Administrator", reason=WHY["reason"], at_s=NOW_S)
    assert machine(house, "M8").shut_out == ShutOutView(by="Administrator", reason="spindle", at_s=NOW_S)
    assert [each["agent"] for each in (await house.get("/api/agents/shut-out"))["items"]] == ["ATV3", "M8"]


def test_the_panels_are_told_when_it_changes_and_not_only_with_the_next_heartbeat() -> None:
    projection = Projection(PLANT, TimeScale(0.0, NOW_S))
    projection.fold(atv_heartbeat("ATV3"))
    projection.fold(machine_heartbeat("M8"))
    projection.discard_changes()
    exclusions = [Exclusion(agent, "why", "Maria", NOW_S) for agent in ("ATV3", "M8", "ATV4")]
    projection.shut_out(exclusions)
    assert [view.shut_out is not None for view in projection.atvs.take_changed()] == [True]
    assert [view.shut_out is not None for view in projection.machines.take_changed()] == [True]
    projection.shut_out(exclusions[1:])
    assert [view.shut_out for view in projection.atvs.take_changed()] == [None]
    assert projection.machines.take_changed() == (), "of this one nothing else is said"


async def test_it_is_written_down_who_did_it_and_why(house: House) -> None:
    boss = await house.log_in("maria")
    assert (await boss.post("/api/agents/ATV3/shut-out", json=WHY)).json()["by"] == "Maria"
    assert (await boss.post("/api/agents/ATV3/readmit")).status_code == 200
    back, out = await house.audit(target="ATV3")
    assert (out.action, out.who, out.result) == ("agent.shut_out", "maria", "done")
    assert (back.action, back.who, back.result) == ("agent.readmit", "maria", "done")
    assert WHY["reason"].encode() in bytes(out.detail)
    assert WHY["reason"].encode() in bytes(back.detail)


async def test_a_readmitted_agent_is_in_no_list_and_the_number_still_grows(house: House) -> None:
    heard = listener(house.bus)
    await shut_out(house)
    answer = await house.client.post("/api/agents/ATV3/readmit")
    assert answer.json()["reason"] == WHY["reason"]
    assert heard[-1] == ShutOut(DECIDED + 1)
    assert (await house.get("/api/agents/shut-out"))["items"] == []
    problem(await house.client.post("/api/agents/ATV3/readmit"), 404, "unknown-exclusion")
    await shut_out(house)
    assert heard[-1] == ShutOut(DECIDED + 2, ("ATV3",))


async def test_a_clock_that_was_set_back_makes_no_decision_older_than_the_one_before(house: House) -> None:
    heard = listener(house.bus)
    await shut_out(house)
    house.wall.now_s -= 3600.0
    await shut_out(house, "M8")
    assert heard[-1] == ShutOut(DECIDED + 1, ("ATV3", "M8"))


async def test_who_shut_it_out_first_stays(house: House) -> None:
    heard = listener(house.bus)
    await shut_out(house)
    assert (await shut_out(house, reason="something else"))["reason"] == WHY["reason"]
    assert {each.number for each in heard} == {DECIDED}


async def test_the_list_is_said_again_and_again_and_nothing_where_nobody_ever_was_shut_out(
    house: House,
) -> None:
    heard = listener(house.bus)
    await house.exclusions.look()
    assert heard == []
    await shut_out(house)
    await house.exclusions.look()
    assert set(heard) == {ShutOut(DECIDED, ("ATV3",))}
    assert len(heard) >= 2
    assert EVERY_S <= 5.0


async def test_it_outlives_a_restart_of_the_gateway_and_no_stop_is_given_again(url: str) -> None:
    async with gateway(url) as house:
        await shut_out(house)
    bus, said = FakeBus(), asyncio.Event()
    heard = listener(bus, said.set)
    async with gateway(url, bus=bus) as house:
        await said.wait()
        assert heard[0] == ShutOut(DECIDED, ("ATV3",))
        assert not house.projection.commands.views()
        house.bus.say(atv_heartbeat("ATV3"))
        assert atv(house).shut_out is not None
        assert house.bus.sent_to("ATV3", VehicleCommand) == []


async def test_what_is_decided_elsewhere_is_seen_and_told(url: str) -> None:
    bus = FakeBus()
    async with (
        gateway(url, bus=bus, gateway_name="g1") as first,
        gateway(url, bus=bus, gateway_name="g2") as other,
    ):
        bus.say(atv_heartbeat("ATV3"))
        await shut_out(first)
        heard = listener(bus)
        await other.exclusions.look()
        assert set(heard) == {ShutOut(DECIDED, ("ATV3",))}
        assert atv(other).shut_out is not None


async def test_the_database_away_the_last_list_is_still_said(
    house: House, monkeypatch: pytest.MonkeyPatch
) -> None:
    await shut_out(house)
    heard = listener(house.bus)
    house.exclusions.say()
    assert set(heard) == {ShutOut(DECIDED, ("ATV3",))}


# --- the vehicle ---------------------------------------------------------------------------------


async def test_a_vehicle_is_stopped_before_it_is_shut_out(house: House) -> None:
    house.bus.say(atv_heartbeat("ATV3"))
    order: list[str] = []

    def receive(_sender: str, message: Message) -> None:
        if not isinstance(message, EventsAsked):
            order.append(type(message).__name__)

    house.bus.join("ATV3", receive).subscribe(KEYS.shut_out)
    await shut_out(house)
    # The list is said again and again; what counts is what came first.
    assert list(dict.fromkeys(order)) == ["VehicleCommand", "ShutOut"]
    (stop,) = house.bus.sent_to("ATV3", VehicleCommand)
    assert stop.kind is CommandKind.STOP
    assert stop.grant is not None
    assert stop.grant.everywhere
    (shown,) = house.projection.commands.views()
    assert (shown.kind, shown.state, shown.by) == ("stop", "not_confirmed", "Administrator")


async def test_nobody_waits_for_the_word_of_a_vehicle_that_is_shut_out(house: House) -> None:
    asked = asyncio.create_task(house.client.post("/api/atvs/ATV3/commands", json={"kind": "stop"}))
    await house.bus.next_to("ATV3", VehicleCommand)
    await shut_out(house)
    answer = (await asked).json()
    assert answer["done"] is False
    assert answer["detail"] == "Administrator has shut ATV3 out: whether it obeys is not known, look at it"


async def test_a_vehicle_that_is_shut_out_can_be_stopped_and_nothing_else(house: House) -> None:
    await shut_out(house)

    def obey(sender: str, message: Message) -> None:
        if isinstance(message, VehicleCommand):
            house.bus.tell("ATV3", sender, CommandAnswered(message.command, done=True))

    house.bus.join("ATV3", obey)
    commands = "/api/atvs/ATV3/commands"
    assert (await house.client.post(commands, json={"kind": "stop"})).status_code == 200
    for body in ({"kind": "resume"}, {"kind": "acknowledge"}, {"kind": "set_speed", "speed_frac": 0.5}):
        problem(await house.client.post(commands, json=body), 409, "shut-out")


# --- what is wrong -------------------------------------------------------------------------------


async def test_it_is_an_alert_and_not_said_to_be_lost(house: House) -> None:
    house.bus.say(atv_heartbeat("ATV3"), machine_heartbeat("M8"))
    await shut_out(house)
    await shut_out(house, "M8", reason="spindle")
    house.wall.now_s += 3600.0
    house.projection.look(house.wall())
    told = [
        (each.kind, each.agent, each.by, each.cause and each.cause.detail)
        for each in house.projection.alerts.views()
    ]
    assert told == [
        ("machine_shut_out", "M8", "Administrator", "spindle"),
        ("atv_shut_out", "ATV3", "Administrator", WHY["reason"]),
    ]


async def test_an_operator_sees_it_in_the_own_area_and_no_other_vehicle_is_named(url: str) -> None:
    home, there = AREAS[:2]
    async with gateway(url) as house:
        await house.say(everything())
        await shut_out(house, ATV[home], reason=f"pushed {ATV[there]} off its lane")
        ana = await house.log_in("ana", Role.OPERATOR, home)
        shown = (await ana.get(f"/api/atvs/{ATV[home]}")).json()["shut_out"]
    assert shown["reason"] == "pushed * off its lane"


# --- who and what is refused ---------------------------------------------------------------------


async def test_operators_and_keys_without_the_scope_shut_nobody_out(house: House) -> None:
    ana = await house.log_in("ana", Role.OPERATOR, "AREA1")
    _, header = await house.key(*(set(Scope) - {Scope.AGENTS_WRITE}))
    key = house.visitor(**header)
    for somebody in (ana, key):
        problem(await somebody.post("/api/agents/ATV3/shut-out", json=WHY), 403, "not-allowed")
        problem(await somebody.post("/api/agents/ATV3/readmit"), 403, "not-allowed")
    assert (await house.get("/api/agents/shut-out"))["items"] == []


@pytest.mark.parametrize(
    "body",
    [
        {},
        {"reason": None, "detail": "", "text": ""},
        {"reason": "   "},
        {"reason": "a\nb"},
        {"reason": "x" * 201},
    ],
)
async def test_without_a_reason_nobody_is_shut_out(house: House, body: dict[str, str]) -> None:
    problem(await house.client.post("/api/agents/ATV3/shut-out", json=body), 422, "unusable-fields")


async def test_an_agent_that_nobody_knows_is_not_shut_out_by_mistake(house: House) -> None:
    problem(await house.client.post("/api/agents/ATV33/shut-out", json=WHY), 404, "unknown-agent")


async def test_a_gateway_does_not_shut_itself_out(house: House) -> None:
    problem(await house.client.post("/api/agents/gateway/shut-out", json=WHY), 409, "own-gateway")


async def test_no_more_are_shut_out_than_a_message_can_name(house: House) -> None:
    async with house.store.write() as work:
        for number in range(MAX_SHUT_OUT):
            await work.exclusions.put(Exclusion(f"X{number}", "too many", "Maria", NOW_S))
    problem(await house.client.post("/api/agents/ATV3/shut-out", json=WHY), 409, "too-many-shut-out")
