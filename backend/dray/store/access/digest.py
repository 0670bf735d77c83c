"""The stored form of a token that somebody else holds."""

from __future__ import annotations

import hashlib


def digest(token: str) -> str:
    """A token's SHA-256: the token has 192 random bits or more, so a plain hash cannot be reversed."""
    return hashlib.sha256(token.encode("utf-8", "surrogatepass")).hexdigest()
