"""When shifts begin, as people write it into the settings."""

from __future__ import annotations

import re

_SHIFT = re.compile(r"(?P<name>\w[\w -]{0,19}) (?P<hour>[01]\d|2[0-3]):(?P<minute>[0-5]\d)")


def shifts_of(text: str) -> tuple[tuple[str, int], ...]:
    """The shifts of a day: name and beginning of each, in minutes after midnight.

    Raises:
        ValueError: with what to write instead.
    """
    found = [_SHIFT.fullmatch(part.strip()) for part in text.split(",")]
    begins = [(each["name"], int(each["hour"]) * 60 + int(each["minute"])) for each in found if each]
    minutes = [minute for _, minute in begins]
    if None in found or minutes != sorted(set(minutes)) or len({name for name, _ in begins}) < len(begins):
        raise ValueError(
            "name each shift and its beginning, the earliest first, as: early 06:00, late 14:00, night 22:00"
        )
    return tuple(begins)


def checked_shifts(text: str) -> str:
    """Check the text, and return it unchanged.

    Raises:
        ValueError: as `shifts_of`.
    """
    shifts_of(text)
    return text
