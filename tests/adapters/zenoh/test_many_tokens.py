"""What an agent with a valid certificate can cost others: any number of its tokens, what it says when it is shut out, and what it says too often,
next to nothing."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Iterable
from contextlib import asynccontextmanager, closing, suppress
from functools import partial
from pathlib import Path

import pytest
from issued import issued
from zenoh_kit import Row

from dray.adapters.security import seals
from dray.adapters.security.identity import Identity
from dray.adapters.security.letters import Letters, Place
from dray.adapters.zenoh import bus as bus_module
from dray.adapters.zenoh.bus import UNSEALED, ZenohBus, ZenohSession
from dray.adapters.zenoh.shares import AT_ONCE_S, SAID_PER_S, TALKATIVE, Shares, ShareSpentError
from dray.adapters.zenoh.stamp import Stamp, Tally, write_stamp
from dray.codec import encode
from dray.messages import Accepted, Event, Role
from dray.messages.fact import MemoryLost
from dray.messages.kinds import Kind
from dray.messages.speakers import SHUT_OUT

KINDS = {"M1": Kind.MACHINE, "ATV1": Kind.ATV, "ATV9": Kind.ATV}

MANY = 300
"""Lives of one agent, each with a token that it has signed."""


LETTER = Accepted("M1-1", 1, Role.PRIMARY, finish_s=60.0)
"""What a vehicle says to a machine alone."""


@pytest.fixture
def examined(monkeypatch: pytest.MonkeyPatch) -> list[bytes]:
    """What signatures were examined for."""
    examine = seals._verify
    found: list[bytes] = []

    def count(certified: seals.Certified, signature: bytes, signed: bytes) -> None:
        found.append(signed)
        examine(certified, signature, signed)

    monkeypatch.setattr(seals, "_verify", count)
    return found


def of(examined: Iterable[bytes], agent: str) -> int:
    return sum(f"/alive/{agent}/".encode() in signed for signed in examined)


def word_of(agent: str) -> Event:
    return Event(agent=agent, incarnation=1, number=1, at_s=1.0, fact=MemoryLost("damaged"))


def test_an_agent_with_many_tokens_has_one_of_them_examined_by_each_process(
    tmp_path: Path, examined: list[bytes]
) -> None:
    async def main() -> None:
        folder = issued(tmp_path, KINDS)
        row = Row(3, identities=[Identity.in_folder(folder, name) for name in KINDS])
        with closing(row):
            machine, _, talkative = row.buses
            machine.join("M1", lambda *_: None)
            await row.settle()
            liveliness = talkative.inner.liveliness()
            held = [
                liveliness.declare_token(talkative.tokens.key(talkative.tokens.of("ATV9", life)))
                for life in range(1, MANY)
            ]
            await row.settle()
            assert of(examined, "ATV9") <= len(KINDS)
            # It is there all the same, and can be written to.
            assert await machine.agents_present() == {"M1", "ATV9"}
            assert machine.seals is not None
            assert machine.seals.register.known("ATV9") is not None
            assert of(examined, "ATV9") <= 2 * len(KINDS)
            for each in held:
                each.undeclare()

    asyncio.run(main())


def test_what_an_agent_says_that_is_shut_out_costs_no_signature(
    tmp_path: Path, examined: list[bytes]
) -> None:
    async def main() -> None:
        folder = issued(tmp_path, KINDS)
        row = Row(2, identities=[Identity.in_folder(folder, name) for name in ("M1", "ATV9")])
        with closing(row):
            machine, talkative = row.buses
            heard: list[str] = []
            listener = machine.join("M1", lambda sender, _message: heard.append(sender))
            listener.subscribe(machine.keys.all_events)
            speaker = talkative.join("ATV9", lambda *_: None)
            word = word_of("ATV9")
            await row.settle()
            speaker.publish(machine.keys.events("ATV9"), word)
            await row.settle()
            before = len(examined)
            machine.shut_out = frozenset({"ATV9"})
            for _ in range(MANY):
                speaker.publish(machine.keys.events("ATV9"), word)
            await row.settle()
            assert heard == ["ATV9"]
            assert machine.refused == {SHUT_OUT: MANY}
            assert len(examined) == before

    asyncio.run(main())


@pytest.fixture
def opened(monkeypatch: pytest.MonkeyPatch) -> list[Place]:
    """Letters that were decrypted."""
    read = Letters.read
    found: list[Place] = []

    def count(self: Letters, seal: bytes, place: Place, letter: bytes) -> tuple[str, Kind, bytes]:
        found.append(place)
        return read(self, seal, place, letter)

    monkeypatch.setattr(Letters, "read", count)
    return found


@asynccontextmanager
async def written_to(tmp_path: Path) -> AsyncIterator[tuple[Row, ZenohBus, ZenohSession, list[str]]]:
    """Two computers: that of M1, which is written to, and ATV9's session on the other; and who M1 has heard."""
    folder = issued(tmp_path, KINDS)
    with closing(Row(2, identities=[Identity.in_folder(folder, name) for name in ("M1", "ATV9")])) as row:
        machine, other = row.buses
        heard: list[str] = []
        machine.join("M1", lambda sender, _message: heard.append(sender))
        speaker = other.join("ATV9", lambda *_: None)
        await row.settle()
        yield row, machine, speaker, heard


def test_letters_of_an_agent_that_is_shut_out_are_not_opened(tmp_path: Path, opened: list[Place]) -> None:
    async def main() -> None:
        async with written_to(tmp_path) as (row, machine, speaker, heard):
            speaker.send("M1", LETTER)
            await row.settle()
            assert heard == ["ATV9"]
            assert len(opened) == 1
            machine.shut_out = frozenset({"ATV9"})
            for _ in range(MANY):
                speaker.send("M1", LETTER)
            await row.settle()
            assert heard == ["ATV9"]
            assert machine.refused == {SHUT_OUT: MANY}
            assert len(opened) == 1

    asyncio.run(main())


def test_letters_of_an_agent_that_writes_too_many_are_not_opened(
    tmp_path: Path, opened: list[Place], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bus_module, "Shares", partial(Shares, now_s=lambda: 0.0))
    share = round(SAID_PER_S * AT_ONCE_S) + 1

    async def main() -> None:
        async with written_to(tmp_path) as (row, machine, speaker, heard):
            for number in range(1, share + MANY + 1):
                speaker.send("M1", LETTER)
                if number % 100 == 0:
                    await row.settle()
            await row.settle()
            assert heard == ["ATV9"] * share
            assert len(opened) == share
            assert machine.refused == {TALKATIVE: MANY}

    asyncio.run(main())


def test_what_an_agent_says_too_often_is_not_heard_and_costs_no_signature_and_others_are_heard(
    tmp_path: Path, examined: list[bytes], monkeypatch: pytest.MonkeyPatch
) -> None:
    now_s = [0.0]
    monkeypatch.setattr(bus_module, "Shares", partial(Shares, now_s=lambda: now_s[0]))
    share = round(SAID_PER_S * AT_ONCE_S) + 1

    async def main() -> None:
        folder = issued(tmp_path, KINDS)
        row = Row(3, identities=[Identity.in_folder(folder, name) for name in KINDS])
        with closing(row):
            machine, honest, talkative = row.buses
            heard: list[str] = []
            listener = machine.join("M1", lambda sender, _message: heard.append(sender))
            listener.subscribe(machine.keys.all_events)
            sessions = {
                bus: bus.join(name, lambda *_: None) for bus, name in ((honest, "ATV1"), (talkative, "ATV9"))
            }

            async def say(bus: ZenohBus, agent: str, times: int) -> None:
                for number in range(1, times + 1):
                    sessions[bus].publish(bus.keys.events(agent), word_of(agent))
                    if number % 100 == 0:
                        await row.settle()
                await row.settle()

            await row.settle()
            # In another one's name: what that one has not signed is none of its share.
            key, data = talkative.keys.events("ATV1"), encode("ATV1", word_of("ATV1"))
            assert talkative.seals is not None
            for number in range(1, MANY + 1):
                seal = talkative.seals.seal(key, 0, number, data)
                talkative.inner.put(key, data, attachment=write_stamp(Stamp(0, number, seal)))
            await row.settle()
            assert machine.refused[UNSEALED] == MANY
            assert not heard
            await say(talkative, "ATV9", share)
            assert heard == ["ATV9"] * share
            before = len(examined)
            await say(talkative, "ATV9", MANY)
            assert heard == ["ATV9"] * share
            assert machine.refused[TALKATIVE] == MANY
            assert len(examined) == before
            await say(honest, "ATV1", 1)
            assert heard[share:] == ["ATV1"]
            # What it has said is said again by somebody else, without end: it is heard all the same when it says something new.
            assert honest.seals is not None
            again = write_stamp(Stamp(0, 1, honest.seals.seal(key, 0, 1, data)))
            for number in range(1, share + MANY + 1):
                talkative.inner.put(key, data, attachment=again)
                if number % 100 == 0:
                    await row.settle()
            await row.settle()
            assert len(heard) == 2 * share + 1
            await say(honest, "ATV1", 1)
            assert heard[2 * share + 1 :] == ["ATV1"]
            del heard[share + 1 :]
            # It has been silent for a second.
            now_s[0] = 1.0
            await say(talkative, "ATV9", MANY)
            assert heard[share + 1 :] == ["ATV9"] * round(SAID_PER_S)

    asyncio.run(main())


def test_those_that_speak_for_thousands_of_orders_may_say_any_number_and_a_fast_clock_counts() -> None:
    def said_by(kind: Kind | None, speed: float = 1.0) -> int:
        shares, said, stamp = Shares(Tally(), speed, lambda: 0.0), 0, Stamp(0, 1)
        with suppress(ShareSpentError):
            while said < MANY * 100:
                shares.check("X", "key", stamp)
                shares.note("X", "key", stamp, kind)
                said += 1
        return said

    assert said_by(Kind.STRATEGIST) == said_by(Kind.GATEWAY) == said_by(None) == MANY * 100
    once = said_by(Kind.MACHINE)
    assert said_by(Kind.ATV, speed=10.0) == pytest.approx(10 * once, abs=10)
