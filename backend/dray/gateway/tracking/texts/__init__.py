"""Texts of the customer's page: which language somebody reads, and dates and numbers in it.

Written here and not taken from a library of locales: three languages need some sixty words of calendar, and
the page keeps to the panels' rule of a 24 hour clock, which such a library would have to be talked out of.
"""

from __future__ import annotations

from collections.abc import Mapping

from dray.gateway.tracking.texts.catalogue import Catalogue
from dray.gateway.tracking.texts.de import DE
from dray.gateway.tracking.texts.en import EN
from dray.gateway.tracking.texts.es import ES

LANGUAGES: Mapping[str, Catalogue] = {"en": EN, "de": DE, "es": ES}

FALLBACK = "en"

HEADER_CHARS = 500
"""Of an Accept-Language header: more than any browser sends."""


def choose(chosen: str, remembered: str, accepted: str) -> str:
    """The language of a page.

    Args:
        chosen: by the address; empty when not at all.
        remembered: by a cookie; empty when not at all.
        accepted: the Accept-Language header (RFC 9110, 12.5.4), however malformed.
    """
    for wanted in (chosen, remembered, *_by_preference(accepted[:HEADER_CHARS])):
        if wanted in LANGUAGES:
            return wanted
    return FALLBACK


def _by_preference(header: str) -> list[str]:
    weighed: list[tuple[float, str]] = []
    for part in header.split(","):
        tag, _, parameter = part.strip().partition(";")
        name, _, value = parameter.strip().partition("=")
        try:
            weight = float(value) if name.strip().lower() == "q" else 1.0
        except ValueError:
            weight = 0.0
        if 0 < weight <= 1:
            weighed.append((-weight, tag.strip().lower().partition("-")[0]))
    # Stable: of equals, the first one.
    return [language for _, language in sorted(weighed, key=lambda pair: pair[0])]


__all__ = ["FALLBACK", "LANGUAGES", "Catalogue", "choose"]
