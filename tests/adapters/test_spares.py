"""A session is heard by a router that has lost its declarations, and loses and doubles nothing at those that have them."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Iterable
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from typing import Any

import pytest
import zenoh
import zenoh_kit
from floor_house import ATV, PLANT, SPEED, way_of
from floor_house import Listener as FloorListener
from zenoh_kit import LEASE_S, PATIENCE_S, Row, free_address, run_patiently

from dray.adapters import spares
from dray.adapters.remote_body import RemoteBody
from dray.adapters.remote_body.wire import body_key
from dray.adapters.spares import Spares, other_form
from dray.adapters.zenoh.bus import ZenohBus, ZenohSession
from dray.adapters.zenoh.claim import Claim
from dray.adapters.zenoh.links import Links
from dray.body import Drive, WayDone
from dray.messages import Message, OrderTaken
from dray_sim.bodies.floor import Floor
from dray_sim.clock.loop import clock
from dray_sim.remote import FloorServer


@dataclass(frozen=True, slots=True)
class ForgetfulLinks(Links):
    """Links of a router that has lost others' declarations of some keys."""

    subscriptions: tuple[str, ...] = ()
    queryables: tuple[str, ...] = ()
    tokens: tuple[str, ...] = ()

    def config(self) -> zenoh.Config:
        all_lost = {
            "declare_subscriber": self.subscriptions,
            "declare_queryable": self.queryables,
            "liveliness_token": self.tokens,
        }
        lost = {message: keys for message, keys in all_lost.items() if keys}
        rules = [
            {
                "id": message,
                "permission": "deny",
                "flows": ["ingress"],
                "messages": [message],
                "key_exprs": list(keys),
            }
            for message, keys in lost.items()
        ]
        control = {
            "enabled": True,
            "default_permission": "allow",
            "rules": rules,
            "subjects": [{"id": "everybody"}],
            "policies": [{"rules": list(lost), "subjects": ["everybody"]}],
        }
        config = Links.config(self)
        config.insert_json5("access_control", json.dumps(control))
        return config


class Listener:
    """An agent that notes the orders that it hears of, by the key."""

    def __init__(self, bus: ZenohBus, patterns: Iterable[str] = ()) -> None:
        self.heard: list[str] = []
        self.session: ZenohSession = bus.join("A", self._receive, 1)
        for pattern in patterns:
            self.session.subscribe(pattern)

    def _receive(self, _sender: str, message: Message) -> None:
        assert isinstance(message, OrderTaken)
        self.heard.append(message.order)


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    """Many turns a second."""
    monkeypatch.setattr(spares, "RENEWED_S", 0.002)


PATTERNS = {"k": "p/k", "task": "p/task/*", "hb": "p/hb/**"}
SAID_ON = {"k": "p/k", "task": "p/task/3-4", "hb": "p/hb/x"}
"""A key of each pattern."""


@pytest.mark.usefixtures("quick")
def test_a_router_that_has_lost_declarations_is_told_of_their_spares() -> None:
    async def main() -> None:
        address = free_address()
        with closing(ZenohBus(Links(listen=(address,), plain=True, lease_s=LEASE_S), "p")) as there:
            # Where a pattern ends with `/**`, what a router refuses contains the spare, too.
            patterns = {word: pattern for word, pattern in PATTERNS.items() if not pattern.endswith("/**")}
            listener = Listener(there, patterns.values())
            links = ForgetfulLinks(
                peers=(address,),
                plain=True,
                lease_s=LEASE_S,
                subscriptions=("p/agent/@A", *patterns.values()),
                tokens=(there.tokens.key(listener.session.token),),
            )
            with closing(ZenohBus(links, "p")) as here:
                speaker = here.join("S", lambda *_: None, 1)
                async with asyncio.timeout(PATIENCE_S):
                    while "A" not in await here.agents_present() or set(listener.heard) != {"own", *patterns}:
                        speaker.send("A", OrderTaken(order="own"))
                        for word in patterns:
                            speaker.publish(SAID_ON[word], OrderTaken(order=word))

    asyncio.run(main())


def test_a_body_is_found_and_used_over_routers_that_have_lost_both_sides_declarations() -> None:
    async def main() -> None:
        address, key = free_address(), body_key(PLANT.id, ATV)
        floor_links = ForgetfulLinks(
            listen=(address,), plain=True, lease_s=LEASE_S, subscriptions=(f"{key}/told",)
        )
        agent_links = ForgetfulLinks(
            peers=(address,), plain=True, lease_s=LEASE_S, subscriptions=(f"{key}/do",), queryables=(key,)
        )
        with closing(floor_links.open()) as there, closing(agent_links.open()) as here:
            server = FloorServer(there, PLANT.id, Floor(PLANT, clock(), seed=1))
            serving = asyncio.create_task(server.run())
            body = RemoteBody(here, PLANT.id, ATV, 1)
            await body.connect()
            listener, way = FloorListener(body), way_of(ATV)
            body.instruct(Drive(order=1, nodes=way, released=len(way)))
            await listener.until(WayDone)
            serving.cancel()
            server.end()

    run_patiently(main(), SPEED)


def test_the_test_kit_waits_for_the_spare_of_a_declaration_that_a_router_has_lost(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(spares, "RENEWED_S", 0.3)
    monkeypatch.setattr(zenoh_kit, "Links", partial(ForgetfulLinks, subscriptions=("p/agent/@A",)))

    async def main() -> None:
        row = Row(3)
        here, _, there = row.buses
        try:
            listener, speaker = Listener(there), here.join("S", lambda *_: None, 1)
            await row.settle()
            speaker.send("A", OrderTaken(order="1"))
            await row.settle()
            assert listener.heard == ["1"]
        finally:
            row.close()

    asyncio.run(main())


TURNS = 60
"""Turns while messages are under way."""


@pytest.mark.usefixtures("quick")
def test_a_router_that_has_the_declarations_loses_and_doubles_nothing_when_their_spares_are_made_anew() -> (
    None
):
    async def main() -> None:
        row = Row(3)
        here, _, there = row.buses
        try:
            listener = Listener(there, PATTERNS.values())
            speaker = here.join("S", lambda *_: None, 1)
            await row.settle()
            count = 0
            while listener.session._spares._turns < TURNS:
                speaker.send("A", OrderTaken(order=f"own-{count}"))
                for word, key in SAID_ON.items():
                    speaker.publish(key, OrderTaken(order=f"{word}-{count}"))
                assert count % 10 or "A" in await here.agents_present()
                await asyncio.sleep(0)
                count += 1
            await row.settle()
            for word in ("own", *SAID_ON):
                assert [said for said in listener.heard if said.startswith(word)] == [
                    f"{word}-{number}" for number in range(count)
                ]
            assert there.missed == 0
            assert not there.refused
        finally:
            row.close()

    asyncio.run(main())


def has_ear(publisher: zenoh.Publisher) -> bool:
    """Whether any router wants what is said there."""
    status: Any = publisher.matching_status  # Zenoh's stub says that it is a bool.
    return bool(status.matching)


@pytest.mark.usefixtures("quick")
def test_what_is_withdrawn_is_not_made_again_and_takes_its_spare_with_it() -> None:
    async def main() -> None:
        row = Row(2)
        here, there = row.buses
        listener, other = Listener(there, PATTERNS.values()), here.inner.declare_publisher("p/k")
        own = here.inner.declare_publisher("p/agent/@A")
        try:
            async with asyncio.timeout(PATIENCE_S):
                while not {"p/k", "p/agent/@A"} <= set(listener.session._spares._made):
                    await row.settle()
                await row.settle()
                assert has_ear(other)
                listener.session.unsubscribe("p/k")
                await row.settle()
                assert not has_ear(other)
                assert has_ear(own)
                listener.session.leave()
                await row.settle()
                assert not has_ear(own)
                assert "A" not in await here.agents_present()
        finally:
            other.undeclare()
            own.undeclare()
            row.close()

    asyncio.run(main())


@pytest.mark.usefixtures("quick")
def test_who_holds_a_claim_does_not_lose_it_to_its_own_spare_and_a_later_one_does() -> None:
    async def main() -> None:
        row = Row(2)
        here, there = row.buses
        lost: list[str] = []
        try:
            first = Claim(here, "floor", lambda: lost.append("first"))
            while not first._spares._made:
                await row.settle()
            second = Claim(there, "floor", lambda: lost.append("second"))
            while not second._spares._made:
                await row.settle()
            await row.settle()
            assert set(lost) == {"second"}
            first.end()
            second.end()
        finally:
            row.close()

    asyncio.run(main())


@pytest.mark.usefixtures("quick")
def test_the_first_spare_is_made_anew_in_every_turn_and_the_others_in_turn(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    async def main() -> None:
        with closing(ZenohBus(Links(plain=True), "p")) as bus:
            made: list[str] = []
            kept, enough = Spares(bus.inner), asyncio.Event()

            def note(key: str) -> None:
                made.append(key)
                if len(made) == 8:
                    enough.set()

            monkeypatch.setattr(kept, "_undeclare", note)
            for key in ("own", "one", "two"):
                kept.of_subscription(key)
            kept.of_token("alive")
            async with asyncio.timeout(PATIENCE_S):
                await enough.wait()
            assert made[:8] == ["own", "one", "own", "two", "own", "alive", "own", "one"]

    asyncio.run(main())


@pytest.mark.parametrize("pattern", ["p/agent/@A", "p/k", "p/task/*", "p/hb/**", "p/hb/*/**"])
def test_the_other_form_is_another_one_and_matches_the_same_keys(pattern: str) -> None:
    form = zenoh.KeyExpr(other_form(pattern))
    assert form != zenoh.KeyExpr(pattern)
    for key in ("p/agent/@A", "p/k", "p/task/3-4", "p/hb/atv/V1", "p/hb/x/y/z", "p/agent/@B", "p/l"):
        assert form.includes(key) == zenoh.KeyExpr(pattern).includes(key)
