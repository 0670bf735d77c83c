"""Rules for secrets that people choose."""

from __future__ import annotations

import re
from itertools import pairwise

from dray.errors import InputError
from dray.gateway.access.login.login import SECRET_CHARS
from dray.gateway.http.fault_codes import text_of

PASSWORD_CHARS = 12
"""Minimum characters: beyond brute force and the well-known passwords."""

PIN_DIGITS = (6, 12)
"""Minimum and maximum digits: at 24 guesses a day, six digits last a hundred years; more than twelve cannot
be remembered."""

BADGE_CHARS = 8
"""Minimum characters: shorter codes could be found by trying all."""


class WeakSecret(InputError):
    """A secret that is easy to guess, or cannot be typed.

    Attributes:
        code: reason (`http.fault_codes`).
        values: values for the reason's text.
    """

    def __init__(self, code: str, **values: int) -> None:
        self.code, self.values = code, {name: str(value) for name, value in values.items()}
        super().__init__(text_of(code, self.values))


def check_password(password: str, person_id: str) -> None:
    """Refuse a password that is easy to guess.

    Raises:
        WeakSecret: says why.
    """
    if not PASSWORD_CHARS <= len(password) <= SECRET_CHARS:
        raise WeakSecret("password_length", least=PASSWORD_CHARS, most=SECRET_CHARS)
    if len(set(password)) < 5 or person_id in password.casefold():
        raise WeakSecret("password_easy")


def check_pin(pin: str) -> None:
    """Refuse a PIN that is easy to guess.

    Raises:
        WeakSecret: says why.
    """
    least, most = PIN_DIGITS
    if not re.fullmatch(rf"[0-9]{{{least},{most}}}", pin):
        raise WeakSecret("pin_digits", least=least, most=most)
    steps = {(int(later) - int(earlier)) % 10 for earlier, later in pairwise(pin)}
    if len(steps) == 1:
        raise WeakSecret("pin_easy")


def check_badge(code: str) -> None:
    """Refuse a badge code that is easy to guess.

    Raises:
        WeakSecret: says why.
    """
    if not BADGE_CHARS <= len(code) <= SECRET_CHARS or not code.isprintable() or code != code.strip():
        raise WeakSecret("badge_length", least=BADGE_CHARS, most=SECRET_CHARS)
