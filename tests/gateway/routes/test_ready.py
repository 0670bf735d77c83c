"""`dray plant ready` asks a gateway: what it asks for is there, and tells what it takes it to tell."""

from __future__ import annotations

import asyncio
from typing import TypeVar

import httpx
import msgspec
import pytest
from fake_bus import PLANT
from gateway_kit import House
from heartbeats import atv_heartbeat, machine_heartbeat, station_heartbeat
from wall_clock import NOW_S

from dray.cli.runtime.ready.agents import agents, bodies, plant_of_gateway
from dray.cli.runtime.ready.answers import Answers, ask
from dray.cli.runtime.ready.finding import Finding, Verdict
from dray.cli.runtime.ready.people import people_and_keys
from dray.errors import SettingsError
from dray.gateway.access.principal import Role, Scope
from dray.messages import MachineStatus
from dray.messages.keys import GATE
from dray.plant import Plant

pytestmark = pytest.mark.anyio

T = TypeVar("T")

WORKS = Plant(PLANT)


class Client:
    """Asks a gateway in this process, from another thread."""

    def __init__(self, client: httpx.AsyncClient, loop: asyncio.AbstractEventLoop, **headers: str) -> None:
        self._client, self._loop, self._headers = client, loop, headers

    def ask(self, method: str, path: str, shape: type[T]) -> T:
        asking = self._client.request(method, path, headers=self._headers)
        answer = asyncio.run_coroutine_threadsafe(asking, self._loop).result()
        assert answer.status_code == 200, answer.text
        return msgspec.json.decode(answer.content, type=shape)

    def date_s(self) -> float | None:
        return NOW_S


async def asked(house: House, **headers: str) -> Answers:
    client = Client(house.client, asyncio.get_running_loop(), **headers)
    return await asyncio.to_thread(ask, client, house.wall)


def verdicts(*findings: Finding) -> dict[str, Verdict]:
    return {each.name: each.verdict for each in findings}


def everybody(house: House, at_s: float = 1.0) -> None:
    house.bus.say(
        *(machine_heartbeat(each, at_s=at_s) for each in WORKS.machines),
        *(station_heartbeat(each, at_s=at_s) for each in (*WORKS.stores, GATE)),
        *(atv_heartbeat(each, at_s=at_s) for each in WORKS.fleet),
    )


async def test_a_plant_whose_agents_are_all_heard_lacks_none(house: House) -> None:
    everybody(house)
    answers = await asked(house)
    found = verdicts(plant_of_gateway(WORKS, answers), bodies(WORKS, answers), *agents(WORKS, (), answers))
    # Nobody plays the strategist on this bus.
    assert found.pop("strategist") is Verdict.MISSING
    assert set(found.values()) == {Verdict.OK}


async def test_who_was_never_heard_is_silent_or_has_a_problem_is_named(house: House) -> None:
    everybody(house)
    house.wall.now_s += 60.0
    said = [each for each in WORKS.machines if each not in {"M3", "M5"}]
    house.bus.say(
        *(machine_heartbeat(each, 2, at_s=60.0) for each in said),
        machine_heartbeat("M5", 2, at_s=60.0, status=MachineStatus.ERROR, problem="its controller is away"),
    )
    answers = await asked(house)
    found = {each.name: each for each in agents(WORKS, (), answers)}
    assert (found["machines"].verdict, found["machines"].seen) == (Verdict.MISSING, "silent: M3")
    assert found["gate"].seen == "silent: gate"
    broken = bodies(WORKS, answers)
    assert (broken.verdict, broken.seen) == (Verdict.MISSING, "with a problem: M5 (its controller is away)")


async def test_people_keys_and_duty_are_read_as_the_gateway_tells_them(house: House) -> None:
    first, *others = WORKS.areas
    await house.know("ana", Role.MANAGER)
    await house.know("ben", Role.OPERATOR, first)
    await house.key(Scope.ORDERS_WRITE, expires_at_s=NOW_S + 86_400.0)
    answers = await asked(house)
    found = {each.name: each for each in people_and_keys(WORKS, answers, NOW_S)}
    assert found["managers"].seen == "with a password: ana"
    assert found["operators"].seen == f"no operator may work in {', '.join(others)}"
    assert found["API keys"].seen == "expired, or expires within 30 days: ERP"
    assert (found["people on duty"].verdict, first in found["people on duty"].seen) == (Verdict.MISSING, True)
    assert answers.clock == (NOW_S, NOW_S, NOW_S)


async def test_what_whoever_asks_may_not_know_is_not_guessed(house: House) -> None:
    _, header = await house.key(Scope.FACTORY_READ)
    answers = await asked(house, **header)
    assert (answers.people, answers.keys, answers.duty) == (None, None, None)
    assert set(verdicts(*people_and_keys(WORKS, answers, NOW_S)).values()) == {Verdict.UNKNOWN}
    _, less = await house.key(Scope.ORDERS_WRITE)
    with pytest.raises(SettingsError, match="does not see the whole plant"):
        await asked(house, **less)


async def test_another_plant_and_another_file_are_told_apart(house: House) -> None:
    everybody(house)
    answers = await asked(house)
    longer = msgspec.structs.replace(PLANT, fleet=PLANT.fleet[:-1], name="Another")
    assert (
        plant_of_gateway(Plant(longer), answers).seen == "its plant file differs from this one in fleet, name"
    )
    other = msgspec.structs.replace(PLANT, plant="other")
    assert (
        plant_of_gateway(Plant(other), answers).seen
        == f"it serves {PLANT.plant}, but the plant of this file is other"
    )


async def test_a_simulated_plant_is_no_plant_in_service(quiet_house: House) -> None:
    answers = await asked(quiet_house)
    assert plant_of_gateway(WORKS, answers).seen == "it is simulated: people may cause faults there"
