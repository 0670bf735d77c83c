"""Which declarations are made anew, and when."""

from __future__ import annotations

import asyncio
from functools import partial

from dray.adapters.zenoh.renewal import RENEWED_S, Renewal
from dray_sim.clock.loop import VirtualLoop


class Router:
    """A router that notes the declarations made to it.

    Attributes:
        made: all that were made, in their order.
        there: those that are not withdrawn; each once.
    """

    def __init__(self) -> None:
        self.made: list[str] = []
        self.there: list[str] = []

    def declare(self, key: str) -> Declared:
        assert key not in self.there, "it is withdrawn first"
        self.made.append(key)
        self.there.append(key)
        return Declared(self, key)


class Declared:
    """One declaration at a router."""

    def __init__(self, router: Router, key: str) -> None:
        self._router, self._key = router, key

    def undeclare(self) -> None:
        self._router.there.remove(self._key)


async def turns(count: int) -> None:
    """Let so many renewals pass."""
    await asyncio.sleep(RENEWED_S * (count + 0.5))


def test_the_first_is_made_anew_in_every_second_turn_and_the_others_in_between() -> None:
    async def main() -> None:
        router, renewal = Router(), Renewal()
        for key in ("own", "alive", "one", "two"):
            renewal.declare(key, partial(router.declare, key))
        router.made.clear()
        await turns(8)
        assert router.made == ["own", "alive", "own", "one", "own", "two", "own", "alive"]
        assert sorted(router.there) == ["alive", "one", "own", "two"]

    with asyncio.Runner(loop_factory=VirtualLoop) as runner:
        runner.run(main())


def test_what_is_withdrawn_is_not_made_again() -> None:
    async def main() -> None:
        router, renewal = Router(), Renewal()
        for key in ("own", "one"):
            renewal.declare(key, partial(router.declare, key))
        renewal.withdraw("one")
        router.made.clear()
        await turns(2)
        assert router.made == ["own", "own"]
        renewal.end()
        await turns(2)
        assert router.made == ["own", "own"]
        assert router.there == []

    with asyncio.Runner(loop_factory=VirtualLoop) as runner:
        runner.run(main())
