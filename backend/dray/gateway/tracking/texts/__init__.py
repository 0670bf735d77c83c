"""Texts of the customer's page, and dates and numbers in its languages.

Written here and not taken from a library of locales: three languages need some sixty words of calendar, and
the page keeps to the panels' rule of a 24 hour clock, which such a library would have to be talked out of.
"""

from __future__ import annotations

from collections.abc import Mapping

from dray.gateway.tracking.texts.catalogue import Catalogue
from dray.gateway.tracking.texts.de import DE
from dray.gateway.tracking.texts.en import EN
from dray.gateway.tracking.texts.es import ES

TEXTS: Mapping[str, Catalogue] = {"en": EN, "de": DE, "es": ES}

__all__ = ["TEXTS", "Catalogue"]
