"""Trust in signatures."""

from __future__ import annotations

from collections.abc import Callable

Trusts = Callable[[bytes, bytes], bool]
"""Called with words and a signature: whether a trusted signer has signed the words."""


def trusts_nobody(_words: bytes, _signature: bytes) -> bool:
    """For an agent without a key: it trusts no signer."""
    return False
