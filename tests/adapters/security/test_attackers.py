"""What somebody can do who has stolen the certificate of one vehicle, on real links: nothing in another's name."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine, Mapping
from pathlib import Path
from typing import Any

import pytest
import zenoh
from issued import issued
from zenoh.handlers import Callback
from zenoh_kit import Row

from dray.adapters.security.certificates import Authority
from dray.adapters.security.identity import Identity
from dray.adapters.security.letters import Place
from dray.adapters.zenoh.bus import UNSEALED, ZenohBus
from dray.adapters.zenoh.stamp import Stamp, write_stamp
from dray.adapters.zenoh.tokens import UNSIGNED
from dray.codec import decode, encode
from dray.errors import WireError
from dray.messages import (
    Accepted,
    AtvHeartbeat,
    AtvStatus,
    Event,
    HandoverAccepted,
    Message,
    Pose,
    Role,
)
from dray.messages.fact import GoodsDelivered
from dray.messages.kinds import Kind
from dray.messages.speakers import FOREIGN_FACT, FOREIGN_NAME

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
    return issued(tmp_path_factory.mktemp("certificates"), AGENTS)


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
        assert await thief.agents_present() == await bus.agents_present() == {"M1"}
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


def test_nobody_is_there_whom_the_bus_has_by_a_forged_token(folder: Path) -> None:
    @among(folder, THIEF, "M1")
    async def test(row: Row) -> None:
        thief, bus = row.buses
        tokens = declared(thief, f"p/alive/ATV1/1/{seal_of(thief, THIEF, 1)}")
        await row.settle()
        assert await bus.agents_present() == frozenset()
        assert set(bus.refused) == {UNSIGNED}
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


# --- letters ---------------------------------------------------------------------------------------

PRICE = Accepted("M1-1", 1, Role.PRIMARY, finish_s=4711.0)
"""What a rival would like to know."""


class Spy:
    """Listens where it has no business; remembers what has come, as (payload, attachment)."""

    def __init__(self, bus: ZenohBus, key: str) -> None:
        self.taken: list[tuple[bytes, bytes]] = []
        self._listener = bus.inner.declare_subscriber(key, Callback(self._take, indirect=False))

    def _take(self, sample: zenoh.Sample) -> None:
        stamp = sample.attachment
        self.taken.append((sample.payload.to_bytes(), b"" if stamp is None else stamp.to_bytes()))


def test_who_listens_on_another_agents_key_reads_nothing(folder: Path) -> None:
    @among(folder, "ATV1", THIEF, "strategist")
    async def test(row: Row) -> None:
        bidder, thief, house = row.buses
        vehicle, strategist = Agent(bidder, "ATV1"), Agent(house, "strategist")
        spy = Spy(thief, "p/agent/@strategist")
        await row.settle()
        vehicle.session.send("strategist", PRICE)
        await row.settle()
        assert strategist.heard == [("ATV1", PRICE)]
        ((payload, _),) = spy.taken
        assert b"M1-1" not in payload
        with pytest.raises(WireError):
            decode(payload)


def test_a_letter_that_is_played_again_to_somebody_else_is_not_read(folder: Path) -> None:
    @among(folder, "ATV1", THIEF, "M1")
    async def test(row: Row) -> None:
        sender, thief, house = row.buses
        vehicle, machine, robbed = Agent(sender, "ATV1"), Agent(house, "M1"), Agent(thief, THIEF)
        spy = Spy(thief, "p/agent/@M1")
        await row.settle()
        vehicle.session.send("M1", PRICE)
        await row.settle()
        ((payload, stamp),) = spy.taken
        for payload_, stamp_ in (
            (payload, stamp),
            (payload[:-1] + b"x", stamp),
            (payload, b"\x93\x01\x01\xc4\x00"),
        ):
            thief.inner.put(f"p/agent/@{THIEF}", payload_, attachment=stamp_)
        thief.inner.put("p/agent/@M1", payload[:-1] + bytes([payload[-1] ^ 1]), attachment=stamp)
        await row.settle()
        assert machine.heard == [("ATV1", PRICE)]
        assert robbed.heard == []
        assert dict(thief.refused) == {UNSEALED: 3}
        assert dict(house.refused) == {UNSEALED: 1}


def test_nobody_writes_in_the_name_of_another(folder: Path) -> None:
    @among(folder, THIEF, "M1")
    async def test(row: Row) -> None:
        thief, house = row.buses
        liar, machine = Agent(thief, THIEF), Agent(house, "M1")
        await row.settle()
        liar.session.agent = "ATV1"  # As a program that lies does.
        liar.session.send("M1", PRICE)
        # As one that lies inside of its letter.
        assert thief.letters is not None
        letter = thief.letters.write(THIEF, Place("M1", 1, 2), encode("ATV1", PRICE))
        assert letter is not None
        thief.inner.put("p/agent/@M1", letter[0], attachment=write_stamp(Stamp(1, 2, letter[1])))
        # And one that writes for all to read.
        thief.inner.put("p/agent/@M1", encode(THIEF, PRICE), attachment=write_stamp(Stamp(1, 3)))
        await row.settle()
        assert machine.heard == []
        assert dict(house.refused) == {UNSEALED: 3}


def test_a_letter_to_somebody_who_is_not_there_is_lost_and_counted(folder: Path) -> None:
    @among(folder, "ATV1", "M1")
    async def test(row: Row) -> None:
        here, there = row.buses
        vehicle = Agent(here, "ATV1")
        await row.settle()
        vehicle.session.send("M1", PRICE)
        assert here.unaddressed == 1
        machine = Agent(there, "M1")
        await row.settle()
        vehicle.session.send("M1", PRICE)
        await row.settle()
        assert machine.heard == [("ATV1", PRICE)]
        assert (here.unaddressed, there.missed) == (1, 0)


def test_letters_find_an_agent_that_has_a_new_certificate(folder: Path, tmp_path: Path) -> None:
    async def main() -> None:
        for name in ("authority.pem", "authority.key"):
            (tmp_path / name).write_bytes((folder / name).read_bytes())
        Authority.load(folder).issue(tmp_path, "p", {"M1": Kind.MACHINE})
        identities = [Identity.in_folder(folder, agent) for agent in ("ATV1", "M1")]
        row = Row(3, identities=[*identities, Identity.in_folder(tmp_path, "M1")])
        try:
            writer, before, now = row.buses
            vehicle, _ = Agent(writer, "ATV1"), Agent(before, "M1", life=1)
            await row.settle()
            machine = Agent(now, "M1", life=2)
            await row.settle()
            # The token of the life before is played again: it says nothing new.
            assert before.seals is not None
            tokens = declared(before, before.tokens.key(before.tokens.of("M1", 1)))
            await row.settle()
            vehicle.session.send("M1", PRICE)
            machine.session.send("ATV1", HandoverAccepted("M1-1", 1))
            await row.settle()
            assert machine.heard == [("ATV1", PRICE)]
            assert vehicle.heard == [("M1", HandoverAccepted("M1-1", 1))]
            assert tokens
        finally:
            row.close()

    asyncio.run(main())
