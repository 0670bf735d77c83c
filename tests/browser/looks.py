"""How a page may look: languages, themes and widths in which it is tried."""

from __future__ import annotations

from itertools import product
from typing import Any, Literal

import pytest
from variants import in_campaigns

LOCALES = {"en": "en-GB", "de": "de-DE", "es": "es-ES"}

Theme = Literal["light", "dark"]

THEMES: tuple[Theme, ...] = ("light", "dark")

WIDTHS_PX = (390, 800, 1024, 1440, 2560)
"""A telephone, a tablet upright and lying, a laptop, and a wall."""


CUT = """(card) => {
  const clip = card.querySelector(".card-body").getBoundingClientRect();
  return [...card.querySelectorAll(".kpi, .spark, .card-foot, .status-row")].filter((row) => {
    const { bottom, top } = row.getBoundingClientRect();
    return top < clip.bottom - 0.5 && bottom > clip.bottom + 0.5;
  }).map((row) => row.className);
}"""
"""The figures of which a part is in sight, and the rest below what scrolls."""

EACH_ONCE = (("en", "light"), ("de", "dark"), ("es", "light"))
"""Every language and every theme."""


def in_every_look(test: Any) -> Any:
    """A test with `language` and `theme`: too many pictures for `make test`, and all of them for `make test-long`."""
    return pytest.mark.parametrize(("language", "theme"), in_campaigns(product(LOCALES, THEMES), *EACH_ONCE))(
        test
    )
