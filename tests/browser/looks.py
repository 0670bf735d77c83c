"""How a page may look: languages, themes and widths in which it is tried."""

from __future__ import annotations

from itertools import product
from typing import Any, Literal

import pytest
from variants import in_campaigns

LOCALES = {"en": "en-GB", "de": "de-DE", "es": "es-ES"}

THEMES: tuple[Literal["light", "dark"], ...] = ("light", "dark")

WIDTHS_PX = (390, 800, 1024, 1440, 2560)
"""A telephone, a tablet upright and lying, a laptop, and a wall."""


EACH_ONCE = (("en", "light"), ("de", "dark"), ("es", "light"))
"""Every language and every theme."""


def in_every_look(test: Any) -> Any:
    """A test with `language` and `theme`: too many pictures for `make test`, and all of them for `make test-long`."""
    return pytest.mark.parametrize(("language", "theme"), in_campaigns(product(LOCALES, THEMES), *EACH_ONCE))(
        test
    )
