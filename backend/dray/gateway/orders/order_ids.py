"""Names of orders, transports, and customers' tracking pages."""

from __future__ import annotations

import secrets

ALPHABET = "0123456789ABCDEFGHJKMNPQRSTVWXYZ"
"""Crockford's base 32: no letter that looks like a digit. Its order is that of ASCII."""

TIME_DIGITS = 9
"""Digits for the time: 32^9 ms last for a thousand years from 1970."""

CHANCE_DIGITS = 4
"""Random digits, one in a million: ids of one millisecond differ, and other ids are hard to guess."""

TOKEN_BYTES = 24
"""192 bits, so that pages cannot be guessed (W3C TAG, capability URLs)."""


def new_order_id(wall_s: float) -> str:
    """An order id that sorts by time, as ``O-1M9K3X2A4-K7QM``."""
    return f"O-{_by_time(wall_s)}"


def new_transport_id(wall_s: float) -> str:
    """A transport id that sorts by time, as ``T-1M9K3X2A4-K7QM``."""
    return f"T-{_by_time(wall_s)}"


def _by_time(wall_s: float) -> str:
    number, digits = int(wall_s * 1000), ""
    for _ in range(TIME_DIGITS):
        number, digit = divmod(number, 32)
        digits = ALPHABET[digit] + digits
    chance = "".join(secrets.choice(ALPHABET) for _ in range(CHANCE_DIGITS))
    return f"{digits}-{chance}"


def new_token() -> str:
    """A name for the customer's page that cannot be guessed."""
    return secrets.token_urlsafe(TOKEN_BYTES)
