"""Texts of the customer's page, and dates and numbers in its languages.

Our own and not a locale library: three languages need some sixty calendar words, and the panels' 24 hour
clock would have to be forced on such a library.
"""

from __future__ import annotations

from collections.abc import Mapping

from dray.gateway.tracking.texts.catalogue import Catalogue
from dray.gateway.tracking.texts.de import DE
from dray.gateway.tracking.texts.en import EN
from dray.gateway.tracking.texts.es import ES

TEXTS: Mapping[str, Catalogue] = {"en": EN, "de": DE, "es": ES}

__all__ = ["TEXTS", "Catalogue"]
