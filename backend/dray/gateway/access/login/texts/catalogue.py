"""The shape of a language: all texts are required, so that no page ever shows a bare key."""

from __future__ import annotations

import msgspec


class Catalogue(msgspec.Struct, frozen=True, kw_only=True):
    """All texts of the login pages in one language; braces hold values."""

    languages: str
    skip: str

    title: str
    manager_heading: str
    operator_heading: str
    id: str
    id_hint: str
    known: str
    somebody_else: str
    password: str
    pin: str
    pin_hint: str
    pin_delete: str
    badge: str
    badge_hint: str
    submit: str
    to_operator: str
    to_manager: str

    wrong_pin: str
    wrong_password: str
    wrong_badge: str
    too_many: str
    seconds: str
    minutes: str
    busy: str
    away: str

    link_heading: str
    link_note: str
    link_submit: str
    gone_heading: str
    gone_note: str

    unknown_heading: str
    unknown_note: str
    unknown_back: str
    unknown_skip: str

    station_heading: str
    station_note: str
    no_station: str
    without_station: str

    help: str
