"""The shape of a language: every language has all of it, so that no page ever shows a bare key."""

from __future__ import annotations

import msgspec

Names = tuple[str, ...]


class Calendar(msgspec.Struct, frozen=True, kw_only=True):
    """How days and times are written; the clock has 24 hours in all of our languages."""

    weekdays: Names
    """Monday first, abbreviated."""
    months: Names
    """January first, abbreviated."""
    day: str
    """With {weekday}, {day} and {month}."""
    day_of_year: str
    """With {day}, {month} and {year}."""
    yesterday: str
    """As within a sentence, like the other two."""
    today: str
    tomorrow: str
    thousands: str
    """Between groups of three digits."""
    thousands_from: int
    """The first number that is grouped."""


class Catalogue(msgspec.Struct, frozen=True, kw_only=True):
    """All texts of the customer's page in one language; braces hold what is filled in."""

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
    """For want of material, where its names are known."""

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

    transport: str
    """Of a plain transport, with {source} and {to}."""
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
