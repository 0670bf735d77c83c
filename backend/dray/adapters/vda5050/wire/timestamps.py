"""A vehicle's timestamps. They are parsed here, since the driver uses no calendar and no clock."""

from __future__ import annotations

import re

_MOMENT = re.compile(
    r"(\d{4})-(\d\d)-(\d\d)[T ](\d\d):(\d\d):(\d\d(?:[.,]\d{1,9})?)(?:Z|([+-])(\d\d):?(\d\d))?", re.ASCII
)

DAYS_OF_EPOCH = 719_468
"""Days from the first of March of year 0 to the first of January 1970."""


def read_timestamp(said: str) -> tuple[float, int] | None:
    """A `timestamp` as unix time, and its year; None for invalid ISO 8601. Without a zone it is UTC."""
    found = _MOMENT.fullmatch(said)
    if found is None:
        return None
    year, month, day, hour, minute = (int(part) for part in found.groups()[:5])
    second = float(found[6].replace(",", "."))
    if not (1 <= month <= 12 and 1 <= day <= 31 and hour <= 24 and minute <= 59 and second < 61.0):
        return None
    zone_s = (3600 * int(found[8]) + 60 * int(found[9])) * (-1 if found[7] == "-" else 1) if found[7] else 0
    return 86_400 * _days(year, month, day) + 3600 * hour + 60 * minute + second - zone_s, year


def _days(year: int, month: int, day: int) -> int:
    """Days since 1970, in a calendar that begins with March and has the leap day last."""
    year -= month <= 2
    before = 365 * year + year // 4 - year // 100 + year // 400
    return before + (153 * ((month + 9) % 12) + 2) // 5 + day - 1 - DAYS_OF_EPOCH
