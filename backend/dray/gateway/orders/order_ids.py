"""Names of orders, transports, and customers' tracking pages."""

from __future__ import annotations

import secrets

ALPHABET = "0123456789ABCDEFGHJKMNPQRSTVWXYZ"
"""Crockford's base 32: no letter that looks like a digit. Its order is that of ASCII."""

TIME_DIGITS = 9
"""Digits for the time: 32^9 ms last for a thousand years from 1970."""

CHANCE_DIGITS = 4
"""Random digits, one in a million: ids of several processes differ, and other ids are hard to guess."""

TOKEN_BYTES = 24
"""192 bits, so that pages cannot be guessed (W3C TAG, capability URLs)."""


class Ids:
    """Ids of one kind, as ``O-1M9K3X2A4-K7QM``, that sort in the order in which they were given.

    Each is of a later millisecond than the one before, so none comes twice, however many are asked for at a time. Those
    of another process differ by chance.

    Args:
        letter: the kind: ``O`` for orders, ``T`` for transports.
    """

    def __init__(self, letter: str) -> None:
        self._letter = letter
        self._last_ms = 0

    def next(self, wall_s: float) -> str:
        """An id of this moment."""
        self._last_ms = max(self._last_ms + 1, int(wall_s * 1000))
        number, digits = self._last_ms, ""
        for _ in range(TIME_DIGITS):
            number, digit = divmod(number, 32)
            digits = ALPHABET[digit] + digits
        chance = "".join(secrets.choice(ALPHABET) for _ in range(CHANCE_DIGITS))
        return f"{self._letter}-{digits}-{chance}"


def new_token() -> str:
    """A name for the customer's page that cannot be guessed."""
    return secrets.token_urlsafe(TOKEN_BYTES)
