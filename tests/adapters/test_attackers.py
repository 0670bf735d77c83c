"""What somebody can do who has stolen the certificate of one vehicle, on real links: nothing in another's name."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine, Mapping
from pathlib import Path
from typing import Any

import pytest
import zenoh
from zenoh_kit import Row

from dray.adapters.certificates import Authority
from dray.adapters.zenoh_bus import ZenohBus
from dray.adapters.zenoh_links import Identity
from dray.adapters.zenoh_tokens import UNSIGNED
from dray.messages import AtvHeartbeat, AtvStatus, Event, Message, Pose
from dray.messages.fact import GoodsDelivered
from dray.messages.speakers import FOREIGN_FACT, FOREIGN_NAME, Kind

AGENTS: Mapping[str, Kind] = {
    "ATV1": Kind.ATV,
    "ATV9": Kind.ATV,
    "M1": Kind.MACHINE,
    "strategist": Kind.STRATEGIST,
    "gateway": Kind.GATEWAY,
}

THIEF = "ATV9"

HUGE = 10**15
"""A life that nobody ever reaches."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Certificates of a plant `p`, one for each agent."""
    made = tmp_path_factory.mktemp("certificates")
    authority = Authority.make("p")
    authority.write(made)
    for agent, kind in AGENTS.items():
        authority.issue(made, "p", {agent: kind})
    return made


class Agent:
    """Joins the bus of its own process and remembers what it hears."""

    def __init__(self, bus: ZenohBus, name: str, life: int = 1) -> None:
        self.heard: list[tuple[str, Message]] = []
        self.session = bus.join(name, lambda sender, message: self.heard.append((sender, message)), life)


def among(folder: Path, *agents: str) -> Callable[[Callable[[Row], Coroutine[Any, Any, None]]], None]:
    """Run a test on computers in a row, each with the certificate of one agent."""

    def on(test: Callable[[Row], Coroutine[Any, Any, None]]) -> None:
        async def main() -> None:
            row = Row(len(agents), identities=[Identity.in_folder(folder, agent) for agent in agents])
            try:
                await test(row)
            finally:
                row.close()

        asyncio.run(main())

    return on


def beat(atv: str, incarnation: int) -> AtvHeartbeat:
    return AtvHeartbeat(
        atv=atv,
        incarnation=incarnation,
        seq=1,
        at_s=0.0,
        status=AtvStatus.IDLE,
        pose=Pose(0.0, 0.0, 0.0),
        node="n1",
        speed_mps=0.0,
        battery_frac=1.0,
    )


def declared(bus: ZenohBus, *keys: str) -> list[zenoh.LivelinessToken]:
    """Tokens that are there as long as somebody holds them."""
    return [bus.inner.liveliness().declare_token(key) for key in keys]


def seal_of(bus: ZenohBus, agent: str, life: int) -> str:
    """What one agent's certificate can say of itself."""
    return bus.tokens.of(agent, life).seal


# --- tokens ----------------------------------------------------------------------------------------

FORGERIES: Mapping[str, Callable[[ZenohBus, str], str]] = {
    "as it was before tokens were signed": lambda _, agent: f"p/alive/{agent}/{HUGE}",
    "unsigned": lambda _, agent: f"p/alive/{agent}/{HUGE}/-",
    "no seal": lambda _, agent: f"p/alive/{agent}/{HUGE}/kqR0ZXN0xAR0ZXN0",
    "signed by the thief": lambda bus, agent: f"p/alive/{agent}/{HUGE}/{seal_of(bus, THIEF, HUGE)}",
}


@pytest.mark.parametrize("forge", FORGERIES.values(), ids=FORGERIES)
def test_nobody_says_that_another_agent_lives_on_elsewhere(
    folder: Path, forge: Callable[[ZenohBus, str], str]
) -> None:
    @among(folder, THIEF, "M1")
    async def test(row: Row) -> None:
        thief, bus = row.buses
        told: list[str] = []
        bus.replaced = told.append
        Agent(bus, "M1", life=4)
        await row.settle()
        tokens = declared(thief, forge(thief, "M1"))
        await row.settle()
        Agent(bus, "M1", life=5)
        await row.settle()
        assert told == []
        assert await thief.roll_call() == await bus.roll_call() == {"M1"}
        # The old way matches nobody's subscription any more.
        assert set(bus.refused) <= {UNSIGNED}
        assert tokens


def test_a_token_is_signed_for_one_life(folder: Path) -> None:
    @among(folder, THIEF, "M1")
    async def test(row: Row) -> None:
        thief, bus = row.buses
        told: list[str] = []
        bus.replaced = told.append
        Agent(bus, "M1", life=4)
        await row.settle()
        of_now, of_before = (
            f"p/alive/M1/{life}/{seal_of(bus, 'M1', of)}" for life, of in ((HUGE, 4), (3, 3))
        )
        tokens = declared(thief, of_now, of_before)
        await row.settle()
        assert told == []
        assert dict(bus.refused) == {UNSIGNED: 1}
        assert tokens


def test_nobody_is_there_whom_the_roll_call_has_by_a_forged_token(folder: Path) -> None:
    @among(folder, THIEF, "M1")
    async def test(row: Row) -> None:
        thief, bus = row.buses
        tokens = declared(thief, f"p/alive/ATV1/1/{seal_of(thief, THIEF, 1)}")
        await row.settle()
        assert await bus.roll_call() == frozenset()
        assert dict(bus.refused) == {UNSIGNED: 1}
        assert tokens


# --- words -----------------------------------------------------------------------------------------


def test_a_vehicle_does_not_tell_that_goods_have_arrived(folder: Path) -> None:
    arrived = GoodsDelivered(goal="g-1", order="o-1", item=0, product="pump", quantity=4, delivered=4)

    @among(folder, THIEF, "gateway")
    async def test(row: Row) -> None:
        thief, bus = row.buses
        panel, liar = Agent(bus, "gateway"), Agent(thief, THIEF)
        panel.session.subscribe("p/event/*")
        await row.settle()
        told = Event(agent=THIEF, incarnation=1, number=1, at_s=0.0, fact=arrived)
        liar.session.publish(f"p/event/{THIEF}", told)
        liar.session.send("gateway", told)
        await row.settle()
        assert panel.heard == []
        assert dict(bus.refused) == {FOREIGN_FACT: 2}


def test_a_vehicle_does_not_take_another_ones_place_by_a_heartbeat_of_a_later_life(folder: Path) -> None:
    @among(folder, THIEF, "gateway")
    async def test(row: Row) -> None:
        thief, bus = row.buses
        panel, liar = Agent(bus, "gateway"), Agent(thief, THIEF)
        panel.session.subscribe("p/hb/**")
        await row.settle()
        liar.session.publish(f"p/hb/atv/{THIEF}", beat("ATV1", incarnation=HUGE))
        liar.session.publish(f"p/hb/atv/{THIEF}", beat(THIEF, incarnation=1))
        await row.settle()
        assert panel.heard == [(THIEF, beat(THIEF, incarnation=1))]
        assert dict(bus.refused) == {FOREIGN_NAME: 1}
