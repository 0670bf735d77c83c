"""Names of orders and transports, and of the pages on which customers follow them."""

from __future__ import annotations

import secrets

ALPHABET = "0123456789ABCDEFGHJKMNPQRSTVWXYZ"
"""Crockford's base 32: no letter that is mistaken for a digit. Its order is that of ASCII."""

TIME_DIGITS = 9
"""32^9 ms last for a thousand years from 1970."""

CHANCE_DIGITS = 4
"""One in a million: ids of the same millisecond differ, and the neighbour's id is not guessed at once."""

TOKEN_BYTES = 24
"""192 bits: whoever guesses a page will not find one (W3C TAG, capability URLs)."""


def new_order_id(wall_s: float) -> str:
    """A name that sorts by time, as ``O-1M9K3X2A4-K7QM``."""
    return f"O-{_by_time(wall_s)}"


def new_transport_id(wall_s: float) -> str:
    """The same for a plain transport, as ``T-1M9K3X2A4-K7QM``."""
    return f"T-{_by_time(wall_s)}"


def _by_time(wall_s: float) -> str:
    number, digits = int(wall_s * 1000), ""
    for _ in range(TIME_DIGITS):
        number, digit = divmod(number, 32)
        digits = ALPHABET[digit] + digits
    chance = "".join(secrets.choice(ALPHABET) for _ in range(CHANCE_DIGITS))
    return f"{digits}-{chance}"


def new_token() -> str:
    """A name for the customer's page, which nobody can guess."""
    return secrets.token_urlsafe(TOKEN_BYTES)
