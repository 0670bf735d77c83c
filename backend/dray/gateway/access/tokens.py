"""Tokens: secrets of browsers and other systems. Only their hashes are stored."""

from __future__ import annotations

import secrets

TOKEN_BYTES = 32
"""256 random bits, so that guessing is impossible."""

KEY_PREFIX = "dray_"
"""Prefix of every API key, so that people and secret scanners recognise one."""

ID_BYTES = 6
"""Bytes of session and key names, which are no secrets."""


def new_token() -> str:
    """A random token for an address or a cookie."""
    return secrets.token_urlsafe(TOKEN_BYTES)


def new_key() -> str:
    """A new API key."""
    return KEY_PREFIX + new_token()


def new_id() -> str:
    """A new name for a session or key."""
    return secrets.token_hex(ID_BYTES)
