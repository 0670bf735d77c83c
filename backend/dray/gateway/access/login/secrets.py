"""Secrets that people choose: what is good enough."""

from __future__ import annotations

import re
from itertools import pairwise

from dray.errors import InputError
from dray.gateway.access.login.login import SECRET_CHARS

PASSWORD_CHARS = 12
"""At least: longer than what is found by trying everything, and than the well-known ones."""

PIN_DIGITS = (6, 12)
"""With 24 guesses a day, six digits last for a hundred years; more than twelve nobody keeps in mind."""

BADGE_CHARS = 8
"""At least: shorter numbers could be guessed by trying them all."""


class WeakSecret(InputError):
    """A secret that is too easy to guess, or cannot be typed."""


def check_password(password: str, person_id: str) -> None:
    """Refuse a password that is too easy to guess.

    Raises:
        WeakSecret: says why.
    """
    if not PASSWORD_CHARS <= len(password) <= SECRET_CHARS:
        raise WeakSecret(
            f"a password has {PASSWORD_CHARS} to {SECRET_CHARS} characters; several words are good"
        )
    if len(set(password)) < 5 or person_id in password.casefold():
        raise WeakSecret("this password is too easy to guess: it repeats itself, or holds the name")


def check_pin(pin: str) -> None:
    """Refuse a PIN that is too easy to guess.

    Raises:
        WeakSecret: says why.
    """
    least, most = PIN_DIGITS
    if not re.fullmatch(rf"[0-9]{{{least},{most}}}", pin):
        raise WeakSecret(f"a PIN has {least} to {most} digits and nothing else")
    steps = {(int(later) - int(earlier)) % 10 for earlier, later in pairwise(pin)}
    if len(steps) == 1:
        raise WeakSecret("this PIN is too easy to guess: its digits follow one another")


def check_badge(code: str) -> None:
    """Refuse a badge's code that is too easy to guess.

    Raises:
        WeakSecret: says why.
    """
    if not BADGE_CHARS <= len(code) <= SECRET_CHARS or not code.isprintable() or code != code.strip():
        raise WeakSecret(
            f"a badge's code has {BADGE_CHARS} to {SECRET_CHARS} characters, with no space around it"
        )
