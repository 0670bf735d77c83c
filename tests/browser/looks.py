"""How a page may look: languages, themes and widths in which it is tried."""

from __future__ import annotations

from typing import Any, Literal

import pytest

LOCALES = {"en": "en-GB", "de": "de-DE", "es": "es-ES"}

THEMES: tuple[Literal["light", "dark"], ...] = ("light", "dark")

WIDTHS_PX = (390, 1024, 1440, 2560)
"""A telephone, a tablet, a laptop, and a wall."""


def in_every_look(test: Any) -> Any:
    """A test with `language` and `theme`: too many pictures for `make test`."""
    for mark in (
        pytest.mark.parametrize("language", LOCALES),
        pytest.mark.parametrize("theme", THEMES),
        pytest.mark.slow,
    ):
        test = mark(test)
    return test
