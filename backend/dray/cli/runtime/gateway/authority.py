"""The key by which a gateway grants commands: made at the first start, and kept with the data."""

from __future__ import annotations

import time

from dray.adapters.security.signing import SigningKey
from dray.store import Store

NAME = "gateway"
"""Of the key in the database: all gateways on one database sign alike."""


async def authority_of(store: Store) -> SigningKey:
    """The signing key of a database; made now when there is none."""
    fresh = SigningKey.generate()
    public = SigningKey(fresh).public
    async with store.write() as work:
        return SigningKey(await work.signing_keys.get(NAME, private=fresh, public=public, now_s=time.time()))
