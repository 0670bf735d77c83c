"""The key with which a gateway signs grants: created at the first start, and stored with the data."""

from __future__ import annotations

import time

from dray.adapters.security.signing import SigningKey
from dray.store import Store

NAME = "gateway"
"""The key's name in the database: all gateways on one database share it."""


async def authority_of(store: Store) -> SigningKey:
    """The signing key of a database; created when missing."""
    fresh = SigningKey.generate()
    public = SigningKey(fresh).public
    async with store.write() as work:
        return SigningKey(await work.signing_keys.get(NAME, private=fresh, public=public, now_s=time.time()))
