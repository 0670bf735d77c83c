"""Tokens: what a browser or another system shows to be recognised. Only their hashes are kept."""

from __future__ import annotations

import secrets

TOKEN_BYTES = 32
"""256 random bits: nobody guesses one."""

KEY_PREFIX = "dray_"
"""Begins every API key, so that people, and programs that look for secrets in files, know one when they see it."""

ID_BYTES = 6
"""Of the names of sessions and keys, which are no secrets."""


def new_token() -> str:
    """A token that nobody can guess; fit for an address or a cookie."""
    return secrets.token_urlsafe(TOKEN_BYTES)


def new_key() -> str:
    """An API key."""
    return KEY_PREFIX + new_token()


def new_id() -> str:
    """A name for a session or key."""
    return secrets.token_hex(ID_BYTES)
