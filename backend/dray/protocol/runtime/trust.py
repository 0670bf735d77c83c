"""Whose word counts, as far as signatures tell."""

from __future__ import annotations

from collections.abc import Callable

Trusts = Callable[[bytes, bytes], bool]
"""Called with words and a signature: whether somebody who is trusted has signed them."""


def trusts_nobody(_words: bytes, _signature: bytes) -> bool:
    """Of an agent that was given no key: it obeys nobody."""
    return False
