"""Texts of the login pages."""

from __future__ import annotations

from collections.abc import Mapping

from dray.gateway.access.texts.catalogue import Catalogue
from dray.gateway.access.texts.de import DE
from dray.gateway.access.texts.en import EN
from dray.gateway.access.texts.es import ES

TEXTS: Mapping[str, Catalogue] = {"en": EN, "de": DE, "es": ES}

__all__ = ["TEXTS", "Catalogue"]
