"""Texts of the login pages."""

from __future__ import annotations

from collections.abc import Mapping

from dray.gateway.access.login.texts.catalogue import Catalogue
from dray.gateway.access.login.texts.de import DE
from dray.gateway.access.login.texts.en import EN
from dray.gateway.access.login.texts.es import ES

TEXTS: Mapping[str, Catalogue] = {"en": EN, "de": DE, "es": ES}

__all__ = ["TEXTS", "Catalogue"]
