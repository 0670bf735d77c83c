"""The agent of a machine whose body is people, as a process that is killed: what it has answered counts, once."""

from __future__ import annotations

import asyncio
import os
import subprocess
import sys
from pathlib import Path

import msgspec
from people_rig import KIND, PLANT, PRODUCT
from zenoh_kit import PATIENCE_S, free_address

from dray.adapters.people.workcell import Kept
from dray.adapters.security.signing import SigningKey
from dray.adapters.zenoh.bus import ZenohBus
from dray.adapters.zenoh.links import Links
from dray.messages import CommandAnswered, CommandRefusal, MachineCommand, Message

AGAIN_S = 1.0
LONG_S = 1e10
"""Later than now, on the plant's clock."""


class Tablet:
    """Says words to M1 until they are answered."""

    def __init__(self, authority: SigningKey) -> None:
        self.address = free_address()
        self.bus = ZenohBus(Links(listen=(self.address,), plain=True), PLANT.id)
        self._authority = authority
        self._session = self.bus.join("gateway", self._hear)
        self._answers: dict[str, asyncio.Future[CommandAnswered]] = {}

    async def say(self, command: MachineCommand, areas: tuple[str, ...] | None = None) -> CommandAnswered:
        answer = self._answers[command.command] = asyncio.get_running_loop().create_future()
        granted = self._authority.grant("M1", command, person="maria", areas=areas, valid_until_s=LONG_S)
        while not answer.done():
            self._session.send("M1", granted)
            await asyncio.wait((answer,), timeout=AGAIN_S)
        return answer.result()

    def _hear(self, _sender: str, message: Message) -> None:
        if isinstance(message, CommandAnswered) and not self._answers[message.command].done():
            self._answers[message.command].set_result(message)


async def begun(folder: Path, peer: str, authority: SigningKey) -> asyncio.subprocess.Process:
    """An agent that is ready."""
    process = await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", "dray", "agent", "machine", "M1", "--body", "people"),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env={
            **os.environ,
            "DRAY_BUS_PLAIN": "true",
            "DRAY_BUS_PEERS": peer,
            "DRAY_TRUSTED_KEYS": authority.public.hex(),
            "DRAY_JOURNAL_FOLDER": str(folder),
        },
        cwd=folder,
    )
    assert process.stdout is not None
    assert (await process.stdout.readline()).decode() == "M1 is ready\n"
    return process


def test_words_count_once_over_a_kill_of_the_agent(tmp_path: Path) -> None:
    async def story() -> None:
        authority = SigningKey(SigningKey.generate())
        tablet = Tablet(authority)
        try:
            made = MachineCommand(command="w1", kind=KIND.MADE, quantity=2)
            first = await begun(tmp_path, tablet.address, authority)
            assert (await tablet.say(made)).done
            assert (await tablet.say(made)).done
            first.kill()
            await first.wait()
            second = await begun(tmp_path, tablet.address, authority)
            assert (await tablet.say(made)).done
            assert (await tablet.say(MachineCommand(command="w2", kind=KIND.MADE, quantity=1))).done
            elsewhere = MachineCommand(command="w3", kind=KIND.MADE, quantity=1)
            assert (await tablet.say(elsewhere, areas=())).reason is CommandRefusal.NOT_HERE
            second.terminate()
            _, told = await second.communicate()
            assert second.returncode == 0, told.decode()
        finally:
            tablet.bus.close()
        kept = msgspec.json.decode((tmp_path / "M1.people.json").read_bytes(), type=Kept)
        assert (kept.stock[PRODUCT], kept.seq) == (3, 3)
        assert [each.key for each in kept.answered] == ["maria/w1", "maria/w2"]

    asyncio.run(asyncio.wait_for(story(), 3 * PATIENCE_S))
