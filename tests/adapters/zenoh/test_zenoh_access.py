"""Zenoh's access control on real links: what is a wired process's own comes in over no link with a vehicle."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from contextlib import ExitStack, closing
from pathlib import Path

import pytest
import zenoh
from issued import issued
from zenoh.handlers import Callback
from zenoh_kit import PATIENCE_S, free_address

from dray.adapters.security.identity import Identity
from dray.adapters.zenoh.access import Apart
from dray.adapters.zenoh.links import Links
from dray.cli.runtime.surroundings import links_of
from dray.messages.kinds import Kind
from dray.plant import default_plant
from dray.settings import Settings

AGENTS: Mapping[str, Kind] = {"M1": Kind.MACHINE, "M2": Kind.MACHINE, "ATV1": Kind.ATV}
APART = Apart("p", vehicles=("ATV1",), wired=("M1", "M2", "strategist"))

THEIRS = ("p/hb/machine/M2", "p/hb/station/S1", "p/task/3-4", "p/goal/pump", "p/event/M2", "p/shut-out")
"""What wired processes publish."""

ITS_OWN = ("p/hb/atv/ATV1", "p/hb/atv/ATV2", "p/event/ATV1", "p/dwell-point/P1", "p/agent/@M1")
"""What a vehicle says, for another one too."""


LETTERS = (
    "p/agent/@strategist",
    "p/agent/@strategist/**",
    "p/*/@strategist",
    "**/@strategist",
    "**/@strategist/**",
)
"""Patterns of the letters to a wired process: its own one, that of its spare, and what a thief might try."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return issued(tmp_path_factory.mktemp("certificates"), AGENTS)


class Listener:
    """Hears keys of a session, on the loop."""

    def __init__(self) -> None:
        self.heard: set[str] = set()
        self._loop, self._more = asyncio.get_running_loop(), asyncio.Event()

    @property
    def callback(self) -> Callback[zenoh.Sample]:
        return Callback(
            lambda sample: self._loop.call_soon_threadsafe(self._note, str(sample.key_expr)), indirect=False
        )

    async def until(self, *keys: str) -> None:
        async with asyncio.timeout(PATIENCE_S):
            while not self.heard.issuperset(keys):
                self._more.clear()
                await self._more.wait()

    def _note(self, key: str) -> None:
        self.heard.add(key)
        self._more.set()


@pytest.mark.parametrize("guest", ["ATV1", "M2"])
@pytest.mark.parametrize("calls", [False, True], ids=["is called", "calls"])
def test_what_is_a_wired_processs_own_comes_in_over_no_link_with_a_vehicle(
    folder: Path, guest: str, calls: bool
) -> None:
    async def main() -> None:
        address = free_address()
        ends = {"listen": (address,)}, {"peers": (address,)}
        mine, other = reversed(ends) if calls else ends
        house_links = Links(**mine, identity=Identity.in_folder(folder, "M1"), apart=APART)
        guest_links = Links(**other, identity=Identity.in_folder(folder, guest))
        with ExitStack() as stack:
            house, there = (
                stack.enter_context(closing(links.open())) for links in (house_links, guest_links)
            )
            at_house, at_guest, tokens = Listener(), Listener(), Listener()
            listeners = [
                house.declare_subscriber("p/**", at_house.callback),
                house.declare_subscriber("p/agent/@M1", at_house.callback),
                house.liveliness().declare_subscriber("p/alive/**", tokens.callback, history=True),
                *(there.declare_subscriber(key, at_guest.callback) for key in LETTERS),
                there.declare_subscriber("p/said/**", at_guest.callback),
            ]
            there_now = [there.liveliness().declare_token(f"p/alive/{name}/1/-") for name in ("M2", "ATV2")]
            await tokens.until("p/alive/ATV2/1/-")
            async with asyncio.timeout(PATIENCE_S):
                # The subscriptions at both ends are known when a word goes through each way.
                while not (at_guest.heard and at_house.heard & {"p/hb/atv/ATV1"}):
                    house.put("p/said", b"")
                    there.put("p/hb/atv/ATV1", b"")
                    await asyncio.sleep(0)
            house.put("p/agent/@strategist", b"a bid")
            house.put("p/said/last", b"")
            for key in (*THEIRS, *ITS_OWN):
                there.put(key, b"")
            there.put("p/last", b"")
            await at_house.until("p/last", *ITS_OWN)
            await at_guest.until("p/said/last")
            if guest == "M2":
                await at_house.until(*THEIRS)
                await at_guest.until("p/agent/@strategist")
                await tokens.until("p/alive/M2/1/-")
            else:
                assert at_house.heard.isdisjoint(THEIRS)
                assert at_guest.heard == {"p/said", "p/said/last"}
                assert tokens.heard == {"p/alive/ATV2/1/-"}
            for declared in (*listeners, *there_now):
                declared.undeclare()

    asyncio.run(main())


@pytest.mark.parametrize(
    ("name", "asked", "apart"), [("M1", True, True), ("M1", False, False), ("ATV1", True, False)]
)
def test_a_wired_process_denies_it_when_it_is_asked_for(name: str, asked: bool, apart: bool) -> None:
    links = links_of(Settings.load(bus_plain=True, bus_apart=asked), default_plant(), name)
    assert (links.apart is not None) is apart
