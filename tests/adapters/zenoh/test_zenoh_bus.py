"""What only the bus on Zenoh has to bear: strangers' bytes, losses on the way, other lives elsewhere."""

from __future__ import annotations

import asyncio
import json
import logging
import os
import time
from collections.abc import Callable, Coroutine
from typing import Any

import pytest
from forbidden import forbidden
from prometheus_client import CollectorRegistry
from zenoh_kit import PATIENCE_S, Row, free_address, multicast_works

from dray.adapters.zenoh import bus as bus_module
from dray.adapters.zenoh.bus import NEWER, ON_A_PATTERN, UNREADABLE, ZenohBus
from dray.adapters.zenoh.links import Links
from dray.adapters.zenoh.stamp import KNOWN, Stamp, Tally, read_stamp, write_stamp
from dray.adapters.zenoh.tokens import UNSIGNED
from dray.cli.runtime.telemetry.bus_meter import BusMeter
from dray.codec import encode
from dray.errors import ProtocolViolation, SettingsError, UnavailableError, WireError
from dray.messages import WIRE_VERSION, Message, OrderTaken


def on(count: int, test: Callable[[Row], Coroutine[Any, Any, None]]) -> None:
    """Run a test with so many computers in a row."""

    async def main() -> None:
        row = Row(count)
        try:
            await test(row)
        finally:
            row.close()

    asyncio.run(main())


class Agent:
    """An agent that remembers the orders that it has heard of."""

    def __init__(self, bus: ZenohBus, name: str, life: int = 0) -> None:
        self.heard: list[str] = []
        self.session = bus.join(name, self._receive, life)

    def _receive(self, sender: str, message: Message) -> None:
        assert isinstance(message, OrderTaken)
        self.heard.append(message.order)


STAMP = write_stamp(Stamp(1, 1))
TAKEN = encode("S", OrderTaken(order="1"))
NEWER_STILL = json.dumps({"v": WIRE_VERSION + 1, "from": "S", "m": {"new": "ways"}}).encode()


@pytest.mark.parametrize(
    ("payload", "stamp", "reason"),
    [
        (b"\xff\xfe", STAMP, UNREADABLE),
        (b"{}", STAMP, UNREADABLE),
        (TAKEN, None, UNREADABLE),
        (TAKEN, b"\xc1", UNREADABLE),
        (TAKEN, b"\x92\x01\xff", UNREADABLE),
        (NEWER_STILL, STAMP, NEWER),
    ],
    ids=["no text", "no message", "no stamp", "stamp of no kind", "negative number", "newer version"],
)
def test_what_cannot_be_read_reaches_nobody_and_is_counted(
    payload: bytes, stamp: bytes | None, reason: str
) -> None:
    async def test(row: Row) -> None:
        here, there = row.buses
        agent = Agent(there, "A")
        agent.session.subscribe("p/k")
        await row.settle()
        for key in ("p/k", "p/agent/@A"):
            here.inner.put(key, payload, attachment=stamp)
        here.inner.put("p/k", TAKEN, attachment=STAMP)
        await row.settle()
        assert agent.heard == ["1"]
        assert dict(there.refused) == {reason: 2}

    on(2, test)


def test_one_that_we_cannot_deal_with_by_our_own_fault_is_counted_and_told_and_the_next_is_heard(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    reads = bus_module.decode_with_context

    def fails(data: bytes) -> tuple[str, Message, str]:
        sender, message, context = reads(data)
        if message == OrderTaken(order="odd"):
            raise RecursionError("of what nobody had thought of")
        return sender, message, context

    async def test(row: Row) -> None:
        here, there = row.buses
        agent, speaker = Agent(there, "A"), Agent(here, "S")
        agent.session.subscribe("p/k")
        registry = CollectorRegistry()
        registry.register(BusMeter(there))
        await row.settle()
        monkeypatch.setattr(bus_module, "decode_with_context", fails)
        for order in ("1", "odd", "2"):
            speaker.session.publish("p/k", OrderTaken(order=order))
            speaker.session.send("A", OrderTaken(order=order))
        await row.settle()
        assert sorted(agent.heard) == ["1", "1", "2", "2"]
        assert there.failures.total == 2
        lost = registry.get_sample_value("dray_bus_messages_lost_total", {"reason": bus_module.FAILED})
        assert lost == 2

    with caplog.at_level(logging.ERROR, "dray.supervision"):
        on(2, test)
    assert "nobody had thought of" in caplog.text


def test_a_publication_names_no_wildcard() -> None:
    async def test(row: Row) -> None:
        agent = Agent(row.buses[0], "A")
        with pytest.raises(ProtocolViolation, match="wildcards"):
            agent.session.publish("p/*", OrderTaken(order="1"))

    on(1, test)


def test_what_was_lost_on_the_way_is_counted_by_whoever_should_have_heard_it() -> None:
    async def test(row: Row) -> None:
        here, there = row.buses
        agent = Agent(there, "A")
        await row.settle()
        for number in (3, 4, 7, 6):
            here.inner.put("p/agent/@A", TAKEN, attachment=write_stamp(Stamp(1, number)))
        await row.settle()
        assert len(agent.heard) == 4
        assert there.missed == 2

    on(2, test)


def test_what_is_delivered_and_lost_is_told_to_prometheus() -> None:
    async def test(row: Row) -> None:
        here, there = row.buses
        registry = CollectorRegistry()
        registry.register(BusMeter(there))
        Agent(there, "A")
        await row.settle()
        for number in (1, 5):
            here.inner.put("p/agent/@A", TAKEN, attachment=write_stamp(Stamp(1, number)))
        here.inner.put("p/agent/@A", NEWER_STILL, attachment=STAMP)
        await row.settle()
        assert registry.get_sample_value("dray_bus_messages_delivered_total") == 2
        for reason, count in (("on the way", 3), (NEWER, 1), ("a full queue", 0)):
            assert registry.get_sample_value("dray_bus_messages_lost_total", {"reason": reason}) == count

    on(2, test)


def test_an_agent_that_joins_elsewhere_is_replaced_here_and_its_process_is_told() -> None:
    async def test(row: Row) -> None:
        here, there = row.buses
        told: list[str] = []
        here.replaced = told.append
        before = Agent(here, "A", life=1)
        speaker = Agent(here, "S")
        await row.settle()
        after = Agent(there, "A", life=2)
        await row.settle()
        before.session.send("S", OrderTaken(order="of the dead"))
        speaker.session.send("A", OrderTaken(order="1"))
        await row.settle()
        assert told == ["A"]
        assert (before.heard, after.heard, speaker.heard) == ([], ["1"], [])
        assert here.unsaid == 1

    on(2, test)


@pytest.mark.parametrize("step_s", [-3600.0, 3600.0], ids=["back", "forward"])
def test_a_process_that_hangs_does_not_win_over_its_restart_when_the_clock_has_been_put(
    monkeypatch: pytest.MonkeyPatch, step_s: float
) -> None:
    async def test(row: Row) -> None:
        here, there = row.buses
        told: list[str] = []
        here.replaced = there.replaced = told.append
        hanging = Agent(here, "A", life=7)
        await row.settle()
        now_s = time.time() + step_s
        monkeypatch.setattr(time, "time", lambda: now_s)
        monkeypatch.setattr(time, "time_ns", lambda: int(now_s * 1e9))
        restarted, speaker = Agent(there, "A", life=8), Agent(there, "S")
        await row.settle()
        speaker.session.send("A", OrderTaken(order="1"))
        await row.settle()
        assert told == ["A"]
        assert (hanging.heard, restarted.heard) == ([], ["1"])

    on(2, test)


def test_of_two_lives_with_one_number_one_leaves() -> None:
    async def test(row: Row) -> None:
        told: list[str] = []
        for bus in row.buses:
            bus.replaced = told.append
            Agent(bus, "A", life=3)
        await row.settle()
        assert told == ["A"]

    on(2, test)


def test_who_keeps_no_journal_replaces_nobody_elsewhere() -> None:
    async def test(row: Row) -> None:
        here, there = row.buses
        told: list[str] = []
        here.replaced = there.replaced = told.append
        first, second, speaker = Agent(here, "A"), Agent(there, "A"), Agent(here, "S")
        await row.settle()
        speaker.session.send("A", OrderTaken(order="1"))
        await row.settle()
        assert told == []
        assert first.heard == second.heard == ["1"]

    on(2, test)


@pytest.mark.parametrize(
    "key", ["p/alive/A/x/-", "p/alive/A/-1/-", f"p/alive/A/{'9' * 5000}/-", "p/alive/A/٣/-"]
)
def test_a_token_that_says_no_life_is_ignored_and_counted(key: str) -> None:
    async def test(row: Row) -> None:
        here, there = row.buses
        agent = Agent(there, "A", life=1)
        with here.inner.liveliness().declare_token(key):
            await row.settle()
            here.inner.put("p/agent/@A", TAKEN, attachment=STAMP)
            await row.settle()
        assert agent.heard == ["1"]
        assert dict(there.refused) == {UNSIGNED: 1}

    on(2, test)


@pytest.mark.parametrize("key", ["p/alive/*/9/-", "p/alive/A$*/9/-", "p/alive/**", "**/A/9/-", "p/*/A/9/-"])
def test_a_token_on_a_pattern_is_nobodys(key: str) -> None:
    async def test(row: Row) -> None:
        here, there = row.buses
        agent = Agent(there, "A", life=1)
        with here.inner.liveliness().declare_token(key):
            await row.settle()
            assert await there.agents_present() == {"A"}
            here.inner.put("p/agent/@A", TAKEN, attachment=STAMP)
            await row.settle()
        assert agent.heard == ["1"]
        assert (set(there.refused), there.failures.total) == ({UNSIGNED}, 0)

    on(2, test)


@pytest.mark.parametrize("key", ["p/hb/**", "p/hb/x$*", "p/**", "p/*/x"])
def test_what_is_said_on_a_pattern_reaches_nobody_and_is_counted(key: str) -> None:
    async def test(row: Row) -> None:
        here, there = row.buses
        agent = Agent(there, "A")
        agent.session.subscribe("p/hb/**")
        await row.settle()
        here.inner.put(key, TAKEN, attachment=STAMP)
        here.inner.put("p/hb/x", TAKEN, attachment=write_stamp(Stamp(1, 2)))
        await row.settle()
        assert agent.heard == ["1"]
        assert dict(there.refused) == {ON_A_PATTERN: 1}

    on(2, test)


def test_who_is_there_is_known_on_every_computer() -> None:
    async def test(row: Row) -> None:
        agents = [Agent(bus, f"A{number}") for number, bus in enumerate(row.buses)]
        await row.settle()
        assert [await bus.agents_present() for bus in row.buses] == [{"A0", "A1", "A2"}] * 3
        agents[0].session.leave()
        row.buses[2].close()
        gone = await until_present(row.buses[1], {"A1"})
        assert gone == {"A1"}

    on(3, test)


async def until_present(bus: ZenohBus, expected: set[str]) -> frozenset[str]:
    """Who is there, as soon as it is as expected."""
    async with asyncio.timeout(PATIENCE_S):
        while (present := await bus.agents_present()) != expected:
            pass
    return present


def test_a_bus_that_is_closed_says_and_hears_nothing_any_more() -> None:
    async def test(row: Row) -> None:
        here, there = row.buses
        closing, staying = Agent(here, "A"), Agent(there, "B")
        await row.settle()
        staying.session.send("A", OrderTaken(order="under way"))
        here.close()
        here.close()
        closing.session.send("B", OrderTaken(order="1"))
        closing.session.publish("p/k", OrderTaken(order="1"))
        await until_present(there, {"B"})
        assert closing.heard == staying.heard == []

    on(2, test)


def test_neighbours_that_close_at_once_disturb_nobody_who_stays() -> None:
    async def test(row: Row) -> None:
        agents = [Agent(bus, f"A{number}") for number, bus in enumerate(row.buses)]
        await row.settle()
        await asyncio.gather(*(asyncio.to_thread(bus.inner.close) for bus in row.buses[2:]))
        assert await until_present(row.buses[0], {"A0", "A1"}) == {"A0", "A1"}
        assert await until_present(row.buses[1], {"A0", "A1"}) == {"A0", "A1"}
        agents[0].session.send("A1", OrderTaken(order="1"))
        agents[1].session.send("A0", OrderTaken(order="2"))
        async with asyncio.timeout(PATIENCE_S):
            while not (agents[0].heard and agents[1].heard):
                await row.buses[0].agents_present()
        assert (agents[0].heard, agents[1].heard) == (["2"], ["1"])

    on(5, test)


# --- links -----------------------------------------------------------------------------------------


def test_plain_links_must_be_asked_for() -> None:
    with pytest.raises(SettingsError, match=r"DRAY_BUS_CERTIFICATES: .*certificates.*DRAY_BUS_PLAIN=true"):
        Links(listen=(free_address(),)).open()


@pytest.mark.parametrize("address", ["7447", "localhost", ":7447", "localhost:", "localhost:99999", "a:b"])
def test_an_address_that_is_none_is_named(address: str) -> None:
    with pytest.raises(SettingsError, match="HOST:PORT"):
        Links(peers=(address,), plain=True).open()


def test_an_address_that_is_taken_is_named() -> None:
    async def test(row: Row) -> None:
        taken = free_address()
        first = Links(listen=(taken,), plain=True).open()
        try:
            with pytest.raises(UnavailableError, match=rf"the bus on {taken}"):
                Links(listen=(taken,), plain=True).open()
        finally:
            first.close()

    on(1, test)


def test_a_peer_that_is_not_there_yet_is_called_until_it_answers() -> None:
    async def main() -> None:
        address = free_address()
        early = ZenohBus(Links(peers=(address,), plain=True), "p")
        late = ZenohBus(Links(listen=(address,), plain=True), "p")
        try:
            late.join("A", lambda *_: None)
            assert await until_present(early, {"A"}) == {"A"}
        finally:
            early.close()
            late.close()

    asyncio.run(main())


def test_others_on_the_same_network_are_found_by_multicast() -> None:
    if not multicast_works():
        forbidden("it lets no multicast through")

    async def main() -> None:
        # A plant of its own: whoever else is found on this network speaks of another one.
        plant = f"p{os.getpid()}"
        here, there = (
            ZenohBus(Links(listen=(free_address(),), multicast=True, plain=True), plant) for _ in range(2)
        )
        try:
            here.join("A", lambda *_: None)
            assert await until_present(there, {"A"}) == {"A"}
        finally:
            here.close()
            there.close()

    asyncio.run(main())


# --- the count of what is missing ------------------------------------------------------------------


def skipped(*stamps: tuple[int, int]) -> list[int]:
    tally = Tally()
    return [tally.skipped("S", "k", Stamp(life, number)) for life, number in stamps]


def test_nothing_is_missing_before_the_first_that_is_heard() -> None:
    assert skipped((1, 17), (1, 18)) == skipped((0, 17), (0, 18)) == [0, 0]


def test_numbers_that_were_skipped_are_missing() -> None:
    assert skipped((1, 1), (1, 4), (1, 5), (1, 7)) == [0, 2, 0, 1]


def test_what_comes_late_or_twice_is_not_missing_and_makes_nothing_missing() -> None:
    assert skipped((1, 1), (1, 4), (1, 2), (1, 4), (1, 5)) == [0, 2, 0, 0, 0]


def test_a_new_life_counts_anew_and_an_old_one_no_more() -> None:
    assert skipped((1, 1), (2, 5), (1, 9), (2, 6)) == [0, 0, 0, 0]


def test_every_sender_and_key_has_its_own_numbers() -> None:
    tally = Tally()
    for sender, key in (("S", "k"), ("T", "k"), ("S", "l")):
        assert tally.skipped(sender, key, Stamp(1, 1)) == 0
    assert tally.skipped("S", "k", Stamp(1, 3)) == 1


def test_what_is_known_of_others_is_bounded() -> None:
    tally = Tally()
    for number in range(KNOWN + 1):
        tally.skipped(f"S{number}", "k", Stamp(1, 1))
    assert tally.skipped("S0", "k", Stamp(1, 9)) == 0
    assert tally.skipped(f"S{KNOWN}", "k", Stamp(1, 9)) == 7


@pytest.mark.parametrize("data", [b"", b"\xc1", b"\x90", b"\x92\xff\x01", b"\x92\x01\xa1x", b"\x91" * 10_000])
def test_bytes_that_are_no_stamp_are_refused(data: bytes) -> None:
    with pytest.raises(WireError):
        read_stamp(data)
