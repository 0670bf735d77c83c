"""The gateway's signing key: made once for a database."""

from __future__ import annotations

import pytest

from dray.store import Store

pytestmark = pytest.mark.anyio


async def test_the_first_key_of_a_name_stays(store: Store) -> None:
    for number in (b"1", b"2"):
        async with store.write() as work:
            kept = await work.signing_keys.get("gateway", private=number * 32, public=number * 32, now_s=1.0)
        assert kept == b"1" * 32


async def test_keys_of_other_names_are_others(store: Store) -> None:
    async with store.write() as work:
        await work.signing_keys.get("gateway", private=b"1" * 32, public=b"1" * 32, now_s=1.0)
        other = await work.signing_keys.get("other", private=b"2" * 32, public=b"2" * 32, now_s=1.0)
    assert other == b"2" * 32
    async with store.read() as work:
        assert await work.signing_keys.public("other") == (b"2" * 32).hex()
        assert await work.signing_keys.public("nobody") is None
