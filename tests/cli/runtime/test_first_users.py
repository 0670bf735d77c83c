"""The people of a first start, and who of them still needs a link."""

from __future__ import annotations

import asyncio
from pathlib import Path

from dray.cli.runtime.gateway.first_users import welcome
from dray.plant import default_plant
from dray.store import open_store

PLANT = default_plant().file


def test_the_first_start_makes_a_manager_and_an_operator_per_area_and_later_ones_nobody(
    tmp_path: Path,
) -> None:
    async def starts() -> None:
        store = await open_store(f"sqlite+aiosqlite:///{tmp_path / 'dray.db'}")
        try:
            first = await welcome(store, PLANT, 1.0)
            assert list(first) == ["manager", *(f"operator-{area.id.lower()}" for area in PLANT.areas)]
            async with store.write() as work:
                operator = await work.people.get("operator-area1")
                assert operator is not None
                assert (operator.role, operator.areas) == ("operator", ("AREA1",))
                await work.people.change("manager", password_hash="hash")
                await work.people.change("operator-area2", disabled_at_s=1.0)
            second = await welcome(store, PLANT, 2.0)
            assert set(first) - set(second) == {"manager", "operator-area2"}
            async with store.write() as work:
                assert len(await work.people.all()) == len(first)
                assert not await work.login_links.use(first["operator-area1"], 3.0)
                assert await work.login_links.use(second["operator-area1"], 3.0)
        finally:
            await store.close()

    asyncio.run(starts())
