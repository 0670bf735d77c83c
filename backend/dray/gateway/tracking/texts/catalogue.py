"""The shape of a language: all texts are required, so that no page ever shows a bare key."""

from __future__ import annotations

import msgspec

Names = tuple[str, ...]


class Calendar(msgspec.Struct, frozen=True, kw_only=True):
    """Forms of days and times; the clock has 24 hours in all our languages."""

    weekdays: Names
    """Monday first, abbreviated."""
    months: Names
    """January first, abbreviated."""
    day: str
    """Form with {weekday}, {day} and {month}."""
    day_of_year: str
    """Form with {day}, {month} and {year}."""
    yesterday: str
    """As within a sentence, like the other two."""
    today: str
    tomorrow: str
    thousands: str
    """Separator of groups of three digits."""
    thousands_from: int
    """First number that is grouped."""


class Catalogue(msgspec.Struct, frozen=True, kw_only=True):
    """All texts of the customer's page in one language; braces hold values."""

    calendar: Calendar

    title: str
    order: str
    your_order: str
    languages: str
    skip: str
    one_part: str
    parts: str

    expected: str
    cannot_say: str
    by_about: str
    range: str
    delivered_at: str
    cancelled_at: str
    not_started: str
    range_note: str
    no_range_note: str
    wanted_by: str

    late_yes: str
    late_maybe: str
    late_delivered: str

    why: dict[str, str]
    """Per `Reason`."""
    why_material: str
    """Lack of material whose names are known."""

    parts_title: str
    made: str
    delivered: str
    of: str

    way_title: str
    stages: dict[str, str]
    """Per `StageName`."""
    pieces_made: str
    pieces_delivered: str
    now: str
    reached: str
    not_reached: str

    transport_title: str
    transport: str
    """Form for a plain transport, with {source} and {to}."""
    transport_stages: dict[str, str]
    """Per `TransportState`, without cancelled."""
    transport_why: dict[str, str]
    """Why it waits, per `TransportWait`."""
    begins: str

    as_of: str
    zone: str
    refresh: str
    live: str
    offline: str
    private: str

    gone_title: dict[str, str]
    """Per `NoPage`."""
    gone_text: dict[str, str]
    gone_help: dict[str, str]
