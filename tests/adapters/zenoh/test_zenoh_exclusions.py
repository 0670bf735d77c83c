"""Who is shut out, on the real bus: told by gateways alone, heard by every process, kept over restarts."""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, closing
from pathlib import Path

import pytest
from issued import issued
from zenoh.handlers import Callback
from zenoh_kit import Row

from dray.adapters.security.identity import Identity
from dray.adapters.zenoh.bus import UNSEALED, ZenohBus
from dray.adapters.zenoh.exclusions import Exclusions
from dray.adapters.zenoh.links import Links
from dray.messages import HandoverAccepted, Message, ShutOut
from dray.messages.base import COUNT_MAX
from dray.messages.kinds import Kind
from dray.messages.shutout import MAX_SHUT_OUT
from dray.messages.speakers import FOREIGN_WORD, SHUT_OUT

KINDS = {"M1": Kind.MACHINE, "ATV1": Kind.ATV, "gateway": Kind.GATEWAY}
HELLO = HandoverAccepted(task="M1-1", epoch=1)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return issued(tmp_path_factory.mktemp("certificates"), KINDS)


class Listener:
    """An agent that remembers what it has heard."""

    def __init__(self, bus: ZenohBus, name: str) -> None:
        self.heard: list[Message] = []
        self.session = bus.join(name, lambda _sender, message: self.heard.append(message))


class Hall:
    """A machine, a vehicle and a gateway, in a row of computers; each knows who is shut out for itself."""

    def __init__(self, folder: Path, notes: Path) -> None:
        self.row = Row(3, identities=[Identity.in_folder(folder, name) for name in KINDS])
        self.files = [notes / f"{name}.shut-out" for name in KINDS]
        self.exclusions = [
            Exclusions(bus, file) for bus, file in zip(self.row.buses, self.files, strict=True)
        ]
        self.machine, self.atv, self.gateway = map(Listener, self.row.buses, KINDS)

    async def decide(self, number: int, *agents: str) -> None:
        """The gateway tells who is shut out; returns when it is known everywhere."""
        self.gateway.session.publish("p/shut-out", ShutOut(number, agents))
        await self.row.settle()


@asynccontextmanager
async def hall(folder: Path, notes: Path) -> AsyncIterator[Hall]:
    made = Hall(folder, notes)
    with closing(made.row):
        await made.row.settle()
        yield made


def test_nobody_hears_an_agent_that_is_shut_out_until_it_is_readmitted(folder: Path, tmp_path: Path) -> None:
    async def main() -> None:
        async with hall(folder, tmp_path) as here:
            await here.decide(1, "M1")
            # The machine has heard it too, and keeps silent; one that does not is heard by nobody all the same.
            here.row.buses[0].shut_out = frozenset()
            here.machine.session.send("ATV1", HELLO)
            await here.row.settle()
            assert here.atv.heard == []
            assert here.row.buses[1].refused == {SHUT_OUT: 1}
            await here.decide(2)
            here.machine.session.send("ATV1", HELLO)
            await here.row.settle()
            assert here.atv.heard == [HELLO]

    asyncio.run(main())


def test_who_knows_to_be_shut_out_says_nothing_and_hears_on(folder: Path, tmp_path: Path) -> None:
    async def main() -> None:
        async with hall(folder, tmp_path) as here:
            await here.decide(1, "M1")
            here.machine.session.send("ATV1", HELLO)
            here.gateway.session.send("M1", ShutOut(9))
            await here.row.settle()
            assert here.row.buses[0].unsaid == 1
            assert here.row.buses[1].refused == {}
            assert here.machine.heard == [ShutOut(9)], "else it could be neither stopped nor readmitted"

    asyncio.run(main())


@pytest.mark.parametrize("liar", ["M1", "ATV1"])
def test_nobody_but_a_gateway_shuts_anybody_out(folder: Path, tmp_path: Path, liar: str) -> None:
    async def main() -> None:
        async with hall(folder, tmp_path) as here:
            speaker = here.machine if liar == "M1" else here.atv
            speaker.session.publish("p/shut-out", ShutOut(7, ("gateway",)))
            await here.row.settle()
            assert [bus.shut_out for bus in here.row.buses] == [frozenset()] * 3
            assert all(bus.refused == {FOREIGN_WORD: 1} for bus in here.row.buses)

    asyncio.run(main())


def test_a_word_of_the_gateways_that_is_played_again_on_another_key_shuts_nobody_out(
    folder: Path, tmp_path: Path
) -> None:
    async def main() -> None:
        async with hall(folder, tmp_path) as here:
            taken: list[tuple[bytes, bytes]] = []

            def take(sample: object) -> None:
                taken.append((sample.payload.to_bytes(), sample.attachment.to_bytes()))  # type: ignore[attr-defined]

            spy = here.row.buses[1].inner.declare_subscriber("p/k", Callback(take, indirect=False))
            await here.row.settle()
            here.gateway.session.publish("p/k", ShutOut(7, ("M1",)))
            await here.row.settle()
            (words, stamp) = taken[0]
            here.row.buses[1].inner.put("p/shut-out", words, attachment=stamp)
            await here.row.settle()
            spy.undeclare()
            assert [bus.shut_out for bus in here.row.buses] == [frozenset()] * 3
            assert here.row.buses[0].refused == {UNSEALED: 1}

    asyncio.run(main())


def test_an_older_list_changes_nothing(folder: Path, tmp_path: Path) -> None:
    async def main() -> None:
        async with hall(folder, tmp_path) as here:
            await here.decide(5, "M1")
            await here.decide(4)
            await here.decide(5)
            assert here.row.buses[1].shut_out == {"M1"}

    asyncio.run(main())


def test_the_next_decision_counts_whatever_number_a_thief_of_a_gateways_certificate_has_said(
    folder: Path, tmp_path: Path
) -> None:
    """A number is the time of its decision. One of the far future counts as the present, over restarts, too."""
    decided = int(time.time() * 1000)
    an_hour = 3_600_000

    async def main() -> None:
        async with hall(folder, tmp_path) as here:
            await here.decide(decided, "M1")
            await here.decide(COUNT_MAX, "ATV1")
            assert here.row.buses[1].shut_out == {"ATV1"}
            await here.decide(decided, "M1")
            assert here.row.buses[1].shut_out == {"ATV1"}, "an older list is still older"
        async with hall(folder, tmp_path) as here:
            await here.decide(decided + an_hour)
            assert [bus.shut_out for bus in here.row.buses] == [frozenset()] * 3

    asyncio.run(main())


def test_a_gateway_is_heard_whatever_a_list_says(folder: Path, tmp_path: Path) -> None:
    """Whoever has stolen a gateway's certificate shuts no other gateway out, which then decides again."""

    async def main() -> None:
        async with hall(folder, tmp_path) as here:
            await here.decide(5, "gateway", "M1")
            assert here.row.buses[1].shut_out == {"gateway", "M1"}
            here.gateway.session.send("ATV1", ShutOut(9))
            await here.decide(6)
            assert here.atv.heard == [ShutOut(9)], "a letter"
            assert [bus.shut_out for bus in here.row.buses] == [frozenset()] * 3
            assert all(not bus.refused and not bus.unsaid for bus in here.row.buses)

    asyncio.run(main())


def test_an_agent_that_calls_itself_a_gateway_stays_shut_out(folder: Path, tmp_path: Path) -> None:
    """By its certificate it is a machine. Nothing that it says is examined."""

    async def main() -> None:
        async with hall(folder, tmp_path) as here:
            await here.decide(5, "gateway", "M1")
            here.row.buses[0].shut_out = frozenset()
            here.machine.session.publish("p/shut-out", ShutOut(6))
            await here.row.settle()
            assert here.row.buses[1].shut_out == {"gateway", "M1"}
            assert here.row.buses[1].refused == {SHUT_OUT: 1}

    asyncio.run(main())


def test_it_is_known_after_a_restart_without_a_gateway(folder: Path, tmp_path: Path) -> None:
    async def main() -> None:
        async with hall(folder, tmp_path) as here:
            await here.decide(5, "M1")
        async with hall(folder, tmp_path) as here:
            assert [bus.shut_out for bus in here.row.buses] == [{"M1"}] * 3
            await here.decide(4)
            assert here.row.buses[1].shut_out == {"M1"}, "and an older list is still older"

    asyncio.run(main())


@pytest.mark.parametrize("torn", [b"", b"{", b'{"type":"ShutOut","number":5,"agents":["*"]}', b"\x00" * 40])
def test_a_torn_file_is_said_and_the_list_heard_again(
    folder: Path, tmp_path: Path, torn: bytes, caplog: pytest.LogCaptureFixture
) -> None:
    async def main() -> None:
        for name in KINDS:
            (tmp_path / f"{name}.shut-out").write_bytes(torn)
        with caplog.at_level(logging.WARNING):
            async with hall(folder, tmp_path) as here:
                assert here.row.buses[1].shut_out == frozenset()
                await here.decide(5, "M1")
                assert here.row.buses[1].shut_out == {"M1"}
        assert "ATV1.shut-out" in caplog.text

    asyncio.run(main())


def test_a_folder_that_cannot_be_written_is_said_and_the_list_counts(
    folder: Path, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    in_the_way = tmp_path / "file"
    in_the_way.write_text("no folder")

    async def main() -> None:
        async with hall(folder, in_the_way / "below") as here:
            await here.decide(5, "M1")
            assert here.row.buses[1].shut_out == {"M1"}

    with caplog.at_level(logging.WARNING):
        asyncio.run(main())
    assert "cannot be written" in caplog.text


def test_the_longest_list_fits_into_a_message(tmp_path: Path) -> None:
    async def main() -> None:
        with closing(ZenohBus(Links(plain=True), "p")) as bus:
            Exclusions(bus, tmp_path / "x.shut-out")
            said = ShutOut(1, tuple(f"{number:0128d}" for number in range(MAX_SHUT_OUT)))
            heard = asyncio.Event()
            loop = asyncio.get_running_loop()
            bus.inner.declare_subscriber("p/shut-out", lambda _: loop.call_soon_threadsafe(heard.set))
            Listener(bus, "gateway").session.publish("p/shut-out", said)
            await heard.wait()
            assert bus.refused == {}
            assert len(bus.shut_out) == MAX_SHUT_OUT

    asyncio.run(main())
