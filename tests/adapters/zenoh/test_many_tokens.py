"""What an agent with a valid certificate can cost others: any number of its tokens, and what it says when it is shut out, next to nothing."""

from __future__ import annotations

import asyncio
from collections.abc import Iterable
from contextlib import closing
from pathlib import Path

import pytest
from issued import issued
from zenoh_kit import Row

from dray.adapters.security import seals
from dray.adapters.security.identity import Identity
from dray.messages import Event
from dray.messages.fact import MemoryLost
from dray.messages.speakers import SHUT_OUT, Kind

KINDS = {"M1": Kind.MACHINE, "ATV1": Kind.ATV, "ATV9": Kind.ATV}

MANY = 300
"""Lives of one agent, each with a token that it has signed."""


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
            assert await machine.roll_call() == {"M1", "ATV9"}
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
            word = Event(agent="ATV9", incarnation=1, number=1, at_s=1.0, fact=MemoryLost("damaged"))
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
