"""What is kept of a token that somebody else holds."""

from __future__ import annotations

import hashlib


def digest(token: str) -> str:
    """A token's SHA-256: it has 192 random bits or more, so a plain hash cannot be turned round."""
    return hashlib.sha256(token.encode("utf-8", "surrogatepass")).hexdigest()
